#!/usr/bin/env bash
# Draws a picture with GNU parallel, in bands of rows, on the cores of this
# machine or on several hosts that share the folder:
#
#     render-parallel.sh BANDS SCENE IMAGE WIDTH HEIGHT [options of sfera]
#     HOSTS=2/alpha,2/beta render-parallel.sh 64 scene.txt poster.ppm 200000 200000
#
# Stopped or killed, the same command goes on where it was: finished bands are
# in a job log beside the image, which goes when the image is complete.
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

# Bands of another picture are not bands of this one: the log's name holds the
# whole command. Nor is there anything to resume of an image that is gone, or
# older than its scene.
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
