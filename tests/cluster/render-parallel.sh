#!/usr/bin/env bash
# Draws a picture with GNU parallel, in bands of rows, on the cores of this
# machine or on several hosts that share the folder:
#
#     render-parallel.sh BANDS SCENE IMAGE WIDTH HEIGHT [options of sfera]
#     HOSTS=2/alpha,2/beta render-parallel.sh 64 scene.txt poster.ppm 200000 200000
#
# If it was stopped or killed, the same command draws only the missing bands: a job
# log beside the image lists the finished ones. It is removed when the image is complete.
#
#   HOSTS  hosts as --sshlogin takes them; this machine if unset
#   JOBS   processes on each host, as --jobs takes it; 100% if unset: one a core
#   SFERA  the program, if it is not on the PATH of the hosts
set -euo pipefail

if (($# < 5)); then
    echo "usage: render-parallel.sh BANDS SCENE IMAGE WIDTH HEIGHT [options]" >&2
    exit 2
fi
bands=$1
shift
scene=$1 image=$2 height=$4
if ((bands > height)); then
    bands=$height
fi

# The name of the log depends on the whole command, so that bands of another picture
# are not taken for bands of this one. If the image was removed, or is older than its
# scene, all bands are drawn.
joblog=$image.$(printf '%s\n' "$bands" "$@" | cksum | cut -d ' ' -f 1).joblog
if [[ ! -e "$image" || "$scene" -nt "$joblog" ]]; then
    rm -f "$joblog"
fi

across=()
if [[ -n "${HOSTS:-}" ]]; then
    across=(--sshlogin "$HOSTS" --workdir "$PWD")
fi

for ((band = 0; band < bands; band++)); do
    echo "$((height * band / bands))..$((height * (band + 1) / bands))"
done |
    parallel "${across[@]}" --jobs "${JOBS:-100%}" --joblog "$joblog" --resume-failed \
        --retries 3 --halt soon,fail=1 --quote \
        "${SFERA:-sfera}" "$@" --threads 1 --rows {}

rm -f "$joblog"
