#!/usr/bin/env bash
# `make cluster-test`: runs the recipes beside this file on a cluster of two nodes on
# this machine. Bands are killed, and a node is lost while it draws. Needs root on
# Debian; installs the packages that are missing, and removes them afterwards.
#
# The cluster has namespaces of its own (processes, network, mounts, host name): its
# only network is a loopback, it can't reach a Slurm or munge of this machine, and all
# its processes end with the first one.
set -euo pipefail
PATH=$PATH:/usr/sbin:/sbin

recipes=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
NAMESPACES=(--fork --kill-child --pid --mount-proc --mount --net --uts --ipc)
LIMIT=900

# Enough spheres for the slowest way of drawing to take a core about half a
# minute, so that a band of it can be caught in the middle.
SPHERES=6000 WIDTH=1200 HEIGHT=900
SLOW=(--method textbook --scalar)
ARRAY_BANDS=16 BANDS=64 WORKERS=4 KILLS=20

say() { printf '%4d s  %s\n' "$SECONDS" "$*"; }

fail() {
    echo "cluster-test: FAILED: $*" >&2
    exit 1
}

# --- Outside: packages, and the namespaces.

main() {
    ((EUID == 0)) || fail "needs root, to install packages and to make namespaces"
    SFERA=$(realpath "${SFERA:?names the program to test}")
    export SFERA
    [[ -x "$SFERA" ]] || fail "$SFERA is not a program; run 'make cluster-test'"

    cluster='' policy='' packages_before=''
    work=$(mktemp -d "${TMPDIR:-/tmp}/sfera-cluster.XXXXXX")
    trap clean_up EXIT
    trap 'exit 130' INT
    trap 'exit 143' TERM HUP

    install_packages
    unshare "${NAMESPACES[@]}" true ||
        fail "can't make namespaces; a container needs to be a privileged one"
    unshare "${NAMESPACES[@]}" "${BASH_SOURCE[0]}" inside "$work" &
    cluster=$!
    while [[ -n "$(jobs -pr)" ]]; do
        ((SECONDS < LIMIT)) || fail "not done after $LIMIT s"
        sleep 1
    done
    wait "$cluster" || fail "see above"
    say "all of it holds"
}

clean_up() {
    local status=$?
    set +e
    trap '' INT TERM HUP
    [[ -z "$cluster" ]] || kill -KILL "$cluster" 2>/dev/null
    wait
    rm -f "$policy"
    [[ -z "$packages_before" || -n "${KEEP_PACKAGES:-}" ]] || remove_packages
    rm -rf "$work"
    exit "$status"
}

install_packages() {
    local program missing=()
    for program in munged slurmctld slurmd sbatch parallel sshd ssh ip pgrep; do
        command -v "$program" >/dev/null || missing+=("$program")
    done
    ((${#missing[@]})) || return 0
    command -v apt-get >/dev/null || fail "missing: ${missing[*]}; and no apt-get to install them"

    say "installing what is missing: ${missing[*]}"
    packages_before=$work/packages-before
    packages >"$packages_before"
    # Debian starts services as it installs them; this test has its own.
    if [[ ! -e /usr/sbin/policy-rc.d ]]; then
        policy=/usr/sbin/policy-rc.d
        printf '#!/bin/sh\nexit 101\n' >"$policy"
        chmod +x "$policy"
    fi
    export DEBIAN_FRONTEND=noninteractive
    if ! { timeout 300 apt-get update && timeout 300 apt-get install -y --no-install-recommends \
        slurm-wlm munge parallel openssh-server openssh-client iproute2 procps; } \
        >"$work/apt.log" 2>&1; then
        tail -n 20 "$work/apt.log" >&2
        fail "apt-get could not install them"
    fi
}

packages() {
    dpkg-query --show --showformat '${Package}\n' | sort -u
}

# Exactly the packages that this run installed. If another package needs one of them
# by now, dpkg refuses. KEEP_PACKAGES=1 keeps them for the next run.
remove_packages() {
    local new
    mapfile -t new < <(packages | comm -13 "$packages_before" -)
    ((${#new[@]})) || return 0
    say "removing the packages again: ${new[*]}"
    if ! timeout 300 dpkg --purge "${new[@]}" >"$work/dpkg.log" 2>&1; then
        tail -n 20 "$work/dpkg.log" >&2
        echo "cluster-test: some packages stay, see above" >&2
    fi
}

# --- Inside: the first process of the namespaces.

inside() {
    work=$1
    stage="the machine"
    trap report EXIT
    exec </dev/null
    # munged requires that every user can reach its socket.
    chmod 711 "$work"
    mkdir "$work"/{munge,slurm,ssh,logs,bin}
    ip link set lo up
    # Slurm resolves names only for address families that an interface has, and it
    # ignores 127.0.0.1.
    ip address add 127.0.0.2/8 dev lo
    ip address add 127.0.0.3/8 dev lo
    hostname controller
    mount -t tmpfs none /run
    printf '127.0.0.1 localhost controller\n127.0.0.2 node1\n127.0.0.3 node2\n' >"$work/hosts"
    mount --bind "$work/hosts" /etc/hosts

    make_scene >"$work/scene.txt"
    scene=$work/scene.txt
    program=$SFERA
    log_calls
    stage="the picture in one piece"
    "$program" "$scene" "$work/one.ppm" "$WIDTH" "$HEIGHT" "${SLOW[@]}"
    one=$(hash_of "$work/one.ppm")
    say "one picture in one piece: ${one:0:16}"

    stage="munge" && start_munge
    stage="slurm" && start_slurm
    stage="job array, killed" && test_array
    stage="a damaged band" && test_repair
    stage="job arrays of every other band" && test_two_passes
    stage="GNU parallel, killed" && test_parallel
    stage="GNU parallel on two hosts" && start_sshd && test_hosts
    stage="random order" && test_random 0
    stage="random order, killed" && test_random "$KILLS"
}

report() {
    local status=$? log
    ((status == 0)) && return
    set +e
    echo "cluster-test: in stage '$stage'; the logs end with" >&2
    for log in "$work"/logs/*; do
        [[ -s "$log" ]] || continue
        echo "--- $(basename "$log")" >&2
        tail -n 15 "$log" >&2
    done
    exit "$status"
}

make_scene() {
    awk -v spheres="$SPHERES" 'BEGIN {
        srand(7)
        print "VP 1.333 1 1\nBG 255 255 255\nOBJ_N " spheres
        for (i = 0; i < spheres; i++) {
            z = 10 + 90 * rand()
            printf "S %.4f %.4f %.4f %.4f %d %d %d\n", (rand() - 0.5) * 1.4 * z, \
                (rand() - 0.5) * 1.1 * z, z, 0.1 + rand(), 256 * rand(), 256 * rand(), 256 * rand()
        }
    }'
}

# Each call of the program writes a line: the node and the arguments.
log_calls() {
    calls=$work/logs/calls
    : >"$calls"
    cat >"$work/bin/sfera" <<EOF
#!/bin/sh
echo "\${SLURMD_NODENAME:-\${SSH_CONNECTION:-here}} \$*" >>"$calls"
exec "$program" "\$@"
EOF
    chmod +x "$work/bin/sfera"
    export SFERA=$work/bin/sfera
}

hash_of() { sha256sum "$1" | cut -d ' ' -f 1; }

expect_the_picture() {
    [[ "$(hash_of "$1")" == "$one" ]] || fail "$1 differs from the picture in one piece"
}

wait_for() { # SECONDS WHAT COMMAND...
    local end=$((SECONDS + $1)) what=$2
    shift 2
    until "$@"; do
        ((SECONDS < end)) || fail "waited in vain for $what"
        sleep 0.1
    done
}

bands_running() { pgrep -f "^$program .*--rows" || true; }

variable_of() { # PID NAME
    { tr '\0' '\n' <"/proc/$1/environ" | sed -n "s/^$2=//p"; } 2>/dev/null || true
}

bands_on() { # NODE
    local pid
    for pid in $(bands_running); do
        [[ "$(variable_of "$pid" SLURMD_NODENAME)" == "$1" ]] && echo "$pid"
    done
    true
}

parent_of() { ps -o ppid= -p "$1" | tr -d ' '; }

start_munge() {
    # Munge refuses a key that others could write, and a socket that others can't reach.
    (umask 077 && head -c 128 /dev/urandom >"$work/munge/key")
    munged --foreground --socket="$work/munge/socket" --key-file="$work/munge/key" \
        --pid-file="$work/munge/pid" --seed-file="$work/munge/seed" \
        >>"$work/logs/munged" 2>&1 &
    wait_for 20 "munged" munge_answers
}

munge_answers() { munge -n -S "$work/munge/socket" >/dev/null 2>&1; }

start_slurm() {
    declare -gA slurmd
    export SLURM_CONF=$work/slurm/slurm.conf
    # A requeued job waits until its old credential has expired: cred_expire.
    cat >"$SLURM_CONF" <<EOF
ClusterName=sfera
SlurmctldHost=controller(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket,cred_expire=5
MailProg=/bin/true
StateSaveLocation=$work/slurm/state
SlurmctldPidFile=$work/slurm/slurmctld.pid
SlurmdPidFile=$work/slurm/%n.pid
SlurmdSpoolDir=$work/slurm/%n
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdTimeout=10
SchedulerParameters=batch_sched_delay=0
ReturnToService=2
KillWait=2
NodeName=node1 NodeAddr=127.0.0.2 Port=6821 CPUs=2 RealMemory=500
NodeName=node2 NodeAddr=127.0.0.3 Port=6822 CPUs=2 RealMemory=500
PartitionName=all Nodes=node1,node2 Default=YES State=UP
EOF
    mkdir "$work"/slurm/{state,node1,node2}
    slurmctld -D >>"$work/logs/slurmctld" 2>&1 &
    start_node node1
    start_node node2
    wait_for 60 "two idle nodes" nodes_idle
    say "a Slurm of two nodes: $(slurmctld -V)"
}

start_node() {
    slurmd -D -N "$1" >>"$work/logs/slurmd-$1" 2>&1 &
    slurmd[$1]=$!
}

nodes_idle() { [[ "$(timeout 10 sinfo --noheader --Node --format %T 2>/dev/null | sort -u)" == idle ]]; }

submit() { # OPTIONS... SCENE IMAGE WIDTH HEIGHT...
    timeout 30 sbatch --parsable --chdir "$work" --output "$work/logs/job-%A_%a" "$@"
}

array_over() { [[ -z "$(timeout 10 squeue --noheader --job "$1" 2>&1)" ]]; }

expect_completed() { # JOB TASKS
    local jobs
    jobs=$(timeout 10 scontrol --oneliner show job "$1")
    (($(grep -c 'JobState=COMPLETED' <<<"$jobs") == $2)) ||
        fail "of job array $1 not all $2 tasks completed: $(grep -o 'ArrayTaskId=[0-9]*\|JobState=[A-Z_]*' <<<"$jobs" | paste -sd ' ')"
}

test_array() {
    local image=$work/array.ppm job band lost restarts
    job=$(submit --array="0-$((ARRAY_BANDS - 1))" "$recipes/render.sbatch" \
        "$scene" "$image" "$WIDTH" "$HEIGHT" "${SLOW[@]}")
    wait_for 60 "four bands on two nodes" four_bands

    # One program killed, one task requeued, one node lost with all that ran on it.
    mapfile -t lost < <(bands_on node1)
    band=$(variable_of "${lost[1]}" SLURM_ARRAY_TASK_ID)
    kill -KILL "${lost[0]}"
    timeout 10 scontrol requeue "${job}_$band"
    mapfile -t lost < <(bands_on node2)
    kill_node "${slurmd[node2]}" "${lost[@]}"
    say "job array: killed a band, requeued band $band, lost node2 with ${#lost[@]} bands"

    wait_for 240 "the end of the job array" array_over "$job"
    expect_completed "$job" "$ARRAY_BANDS"
    restarts=$(timeout 10 scontrol --oneliner show job "$job" | grep -o 'Restarts=[0-9]*' |
        cut -d = -f 2 | paste -sd + | bc)
    ((restarts >= 2 + ${#lost[@]})) || fail "only $restarts bands were started again"
    expect_the_picture "$image"
    say "job array of $ARRAY_BANDS bands, $restarts of them started again: the same bytes"
    start_node node2
    wait_for 60 "node2 to be back" nodes_idle
}

four_bands() { (($(bands_on node1 | wc -l) == 2 && $(bands_on node2 | wc -l) == 2)); }

kill_node() { # SLURMD BAND...
    local band script
    kill -KILL "$1"
    wait "$1" 2>/dev/null || true
    shift
    for band in "$@"; do
        script=$(parent_of "$band")
        kill -KILL "$(parent_of "$script")" "$script" "$band"
    done
}

test_repair() {
    local image=$work/array.ppm row=$((HEIGHT * 5 / 9)) job
    damage "$image" "$row"
    if "$program" "$scene" "$image" "$WIDTH" "$HEIGHT" "${SLOW[@]}" --verify \
        >"$work/logs/verify" 2>&1; then
        fail "--verify passed a picture with a wrong byte in row $row"
    fi
    grep -qw "$row" "$work/logs/verify" || fail "--verify did not name row $row: $(cat "$work/logs/verify")"
    job=$(BANDS=$ARRAY_BANDS submit --array="$((row * ARRAY_BANDS / HEIGHT))" "$recipes/render.sbatch" \
        "$scene" "$image" "$WIDTH" "$HEIGHT" "${SLOW[@]}")
    wait_for 60 "one band" array_over "$job"
    expect_the_picture "$image"
    say "a wrong byte found by --verify, its band drawn again: the same bytes"
}

damage() { # IMAGE ROW
    local at=$(($(stat --format %s "$1") - 3 * WIDTH * (HEIGHT - $2) + WIDTH)) byte
    byte=$(od --address-radix n --format u1 --skip-bytes "$at" --read-bytes 1 "$1")
    printf '%b' "\\x$(printf %02x $((byte ^ 1)))" |
        dd of="$1" bs=1 seek="$at" conv=notrunc status=none
}

# Even bands, then odd ones, for file systems that are consistent only by whole pages:
# bands that are drawn at the same time then share no page.
test_two_passes() {
    local image=$work/passes.ppm even odd
    export BANDS
    even=$(submit --array="0-$((BANDS - 1)):2" "$recipes/render.sbatch" \
        "$scene" "$image" "$WIDTH" "$HEIGHT" "${SLOW[@]:0:2}")
    odd=$(submit --array="1-$((BANDS - 1)):2" --dependency=afterok:"$even" "$recipes/render.sbatch" \
        "$scene" "$image" "$WIDTH" "$HEIGHT" "${SLOW[@]:0:2}")
    export -n BANDS
    local start=$SECONDS
    wait_for 240 "two job arrays" array_over "$odd"
    expect_completed "$even" "$((BANDS / 2))"
    expect_completed "$odd" "$((BANDS / 2))"
    expect_the_picture "$image"
    say "job arrays of even, then odd bands, $BANDS in $((SECONDS - start)) s on 4 slots: the same bytes"
}

# As by a power failure: parallel, its script and the bands are killed at once.
test_parallel() {
    local image=$work/parallel.ppm script finished before
    local command=("$recipes/render-parallel.sh" "$BANDS" "$scene" "$image" "$WIDTH" "$HEIGHT" "${SLOW[@]}")
    "${command[@]}" >"$work/logs/parallel" 2>&1 &
    script=$!
    wait_for 120 "twelve finished bands" joblog_holds 12 "$image"
    # shellcheck disable=SC2046 # a list of processes
    kill -KILL "$script" $(pgrep -P "$script") $(bands_running)
    wait "$script" 2>/dev/null || true
    finished=$(($(cat "$image".*.joblog | wc -l) - 1))
    [[ "$(hash_of "$image")" != "$one" ]] || fail "killed, and yet the picture is complete"

    before=$(wc -l <"$calls")
    timeout 240 "${command[@]}" >>"$work/logs/parallel" 2>&1
    (($(wc -l <"$calls") - before == BANDS - finished)) ||
        fail "resumed with $(($(wc -l <"$calls") - before)) bands where $((BANDS - finished)) were left"
    expect_the_picture "$image"
    [[ -z "$(compgen -G "$image.*.joblog")" ]] || fail "the job log is still there"
    say "GNU parallel, killed after $finished of $BANDS bands, did the $((BANDS - finished)) left: the same bytes"
}

joblog_holds() { # BANDS IMAGE
    compgen -G "$2.*.joblog" >/dev/null && (($(cat "$2".*.joblog | wc -l) > $1))
}

start_sshd() {
    ssh-keygen -q -t ed25519 -N '' -f "$work/ssh/host"
    ssh-keygen -q -t ed25519 -N '' -f "$work/ssh/user"
    mkdir -p /run/sshd
    cat >"$work/ssh/sshd_config" <<EOF
HostKey $work/ssh/host
AuthorizedKeysFile $work/ssh/user.pub
StrictModes no
PermitRootLogin prohibit-password
PidFile none
EOF
    cat >"$work/ssh/config" <<EOF
IdentityFile $work/ssh/user
IdentitiesOnly yes
BatchMode yes
StrictHostKeyChecking no
UserKnownHostsFile $work/ssh/known_hosts
LogLevel ERROR
EOF
    # A root account without a password may be locked, and sshd refuses locked accounts.
    sed 's/^root:[^:]*:/root:*:/' /etc/shadow >"$work/ssh/shadow"
    mount --bind "$work/ssh/shadow" /etc/shadow
    "$(command -v sshd)" -D -e -f "$work/ssh/sshd_config" >>"$work/logs/sshd" 2>&1 &
    export PARALLEL_SSH="ssh -F $work/ssh/config"
    wait_for 20 "sshd" ssh_answers
}

ssh_answers() { timeout 5 ssh -F "$work/ssh/config" node2 true 2>/dev/null; }

test_hosts() {
    local image=$work/hosts.ppm host
    HOSTS=2/node1,2/node2 timeout 240 "$recipes/render-parallel.sh" "$BANDS" \
        "$scene" "$image" "$WIDTH" "$HEIGHT" "${SLOW[@]:0:2}" >"$work/logs/parallel" 2>&1
    for host in 127.0.0.2 127.0.0.3; do
        grep -q " $host 22 $scene $image" "$calls" || fail "no band was drawn on $host"
    done
    expect_the_picture "$image"
    say "GNU parallel on two hosts over ssh: the same bytes"
}

test_random() { # KILLS
    local image=$work/random-$1.ppm workers before started victim kills=0
    before=$(wc -l <"$calls")
    shuf --input-range="0-$((BANDS - 1))" | timeout 300 xargs --max-procs "$WORKERS" --replace={} \
        "${BASH_SOURCE[0]}" band "$image" {} "$HEIGHT" "$BANDS" "$WIDTH" "$scene" "${SLOW[@]}" \
        >"$work/logs/random" 2>&1 &
    workers=$!
    while ((kills < $1)); do
        sleep "0.$((RANDOM % 4 + 1))"
        kill -0 "$workers" 2>/dev/null || fail "all bands done after $kills kills of $1"
        victim=$(bands_running | shuf --head-count 1)
        if [[ -n "$victim" ]] && kill -KILL "$victim" 2>/dev/null; then
            kills=$((kills + 1))
        fi
    done
    wait "$workers" || fail "a band failed"
    started=$(($(wc -l <"$calls") - before))
    # A band that was killed at its end may already be complete.
    ((started > BANDS + kills * 3 / 4 || kills == 0)) || fail "$kills kills, but only $started starts"
    expect_the_picture "$image"
    say "$BANDS bands in random order by $WORKERS processes, $kills killed, $started started: the same bytes"
}

# One band, until it is done.
band() { # IMAGE BAND HEIGHT BANDS WIDTH SCENE OPTIONS...
    local image=$1 rows=$(($3 * $2 / $4))..$(($3 * ($2 + 1) / $4)) height=$3 width=$5 scene=$6
    shift 6
    until "$SFERA" "$scene" "$image" "$width" "$height" "$@" --threads 1 --rows "$rows"; do
        (($? > 128)) || exit 255
    done
}

case "${1:-}" in
inside) inside "$2" ;;
band) shift && band "$@" ;;
*) main ;;
esac
