#!/usr/bin/env bash
# `make everywhere`: sfera on other machines. In a folder that holds a Debian of
# its own it is built for them, and run by emulators or only checked. Needs root on
# Debian, some 8 GB and hours; leaves nothing behind.
#
#   tests/everywhere/run.sh [STAGE...]     emulated, tests, wasm, windows and checked, or those named
#   MACHINES="s390x armhf"                 which machines to emulate
#   KEEP=1                                 keep the folder, and go on in it next time
set -euo pipefail
PATH=$PATH:/usr/sbin:/sbin
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

STAGES=(emulated tests wasm windows checked)
MACHINES=${MACHINES:-aarch64 s390x armhf i386}
# Where files can be had that this machine's Debian does not have: its compiler has
# the standard library of other machines, and the sources to build it for more.
SUITE=sid MIRROR=${MIRROR:-http://deb.debian.org/debian}
HERE=x86_64-unknown-linux-gnu
work=$PWD/target/everywhere
debian=$work/debian

# Debian's name of a machine's kind, the compiler's, the C compiler's, the emulator.
# This kernel runs programs of i386 itself.
declare -A ARCHITECTURE=([aarch64]=arm64 [s390x]=s390x [armhf]=armhf [i386]=i386)
declare -A TARGET=([aarch64]=aarch64-unknown-linux-gnu [s390x]=s390x-unknown-linux-gnu
    [armhf]=armv7-unknown-linux-gnueabihf [i386]=i686-unknown-linux-gnu)
declare -A TOOLS=([aarch64]=aarch64-linux-gnu [s390x]=s390x-linux-gnu
    [armhf]=arm-linux-gnueabihf [i386]=i686-linux-gnu)
declare -A EMULATOR=([aarch64]=qemu-aarch64 [s390x]=qemu-s390x [armhf]=qemu-arm [i386]=)

# Small pictures of many scenes, for emulators are slow.
SIZE=(97 65)
FAMILY_SIZE=(33 25)
# Of the tests, those of exactness, bit identity and reading, but for some that take an
# emulator more than minutes.
TESTS=(--lib --test exact --test bit_identity --test reader)
TOO_SLOW=(the_example hashes_for_the_comparison_of_builds large_pictures_of_large_crowds
    exact::tests::{any_mixture,copies_by_the_thousand,every_way_through_a_picture}
    exact::tests::{families_at_full_hd,families_at_sizes_up_to_33,hidden_by_the_million,several_runs}
    exact::tests::every_pixel_of_some_at_full_hd_on_1_2_and_7_threads
    exact::decide::tests::every_rung_sees_the_sphere_that_integers_see
    scene::number::tests::{any_decimal_text,floats_of_every_size_come_back_in_every_notation}
    scene::number::tests::halfway_points_and_their_neighbours_round_as_they_should
    scene::reader::tests::a_damaged_text_gives_the_same_in_windows_as_to_the_parser)

report=()

say() { printf '%5d s  %s\n' "$SECONDS" "$*"; }

note() {
    report+=("$*")
    say "$*"
}

fail() {
    echo "everywhere: FAILED: $*" >&2
    exit 1
}

main() {
    ((EUID == 0)) || fail "needs root, to make a Debian in a folder"
    # What is mounted is seen by this script alone, and goes when it ends, whatever ends it.
    [[ -n "${OWN_MOUNTS:-}" ]] || OWN_MOUNTS=1 exec unshare --mount tests/everywhere/run.sh "$@"
    mkdir -p "$work"
    trap clean_up EXIT
    trap 'exit 130' INT
    trap 'exit 143' TERM HUP

    local stage stages=("$@")
    ((${#stages[@]})) || stages=("${STAGES[@]}")
    for stage in "${stages[@]}"; do
        [[ " ${STAGES[*]} " == *" $stage "* ]] || fail "no stage $stage; there are: ${STAGES[*]}"
    done
    make_debian
    copy_sources
    for stage in "${stages[@]}"; do
        "stage_$stage"
    done
    for stage in "${STAGES[@]}"; do
        [[ " ${stages[*]} " == *" $stage "* ]] || note "stage $stage: SKIPPED"
    done
    printf '%s\n' "" "${report[@]}"
}

clean_up() {
    local status=$?
    set +e
    [[ -z "${running:-}" ]] || kill -- "-$running"
    umount --lazy "$debian"/{cargo/registry,proc,dev} 2>/dev/null
    [[ -z "${installed:-}" ]] || dpkg --purge debootstrap >/dev/null
    [[ -n "${KEEP:-}" ]] || remove "$work"
    exit "$status"
}

# Never through a mount that would not go: that may be this machine's /dev.
remove() {
    ! grep -q " $1/" /proc/mounts || fail "something is mounted in $1"
    rm -rf "$1"
}

# So that a signal ends this script, and that command with all that it started, at once.
interruptibly() {
    local status=0
    set -m
    "$@" &
    running=$!
    set +m
    wait "$running" || status=$?
    running=
    return "$status"
}

# --- A Debian in a folder.

make_debian() {
    if [[ ! -e "$debian/made" ]]; then
        remove "$debian"
        if ! command -v debootstrap >/dev/null; then
            quietly apt-get update
            installed=1
            quietly apt-get install -y --no-install-recommends debootstrap
        fi
        say "making a Debian $SUITE in $debian"
        quietly interruptibly debootstrap --variant=minbase --include=ca-certificates "$SUITE" "$debian" "$MIRROR"
        # A mirror may be older than its promise.
        printf '%s\n' 'Acquire::Check-Valid-Until "false";' 'APT::Install-Recommends "false";' 'Acquire::Languages "none";' \
            >"$debian/etc/apt/apt.conf.d/99everywhere"
        touch "$debian/made"
    fi
    mount -t proc proc "$debian/proc"
    mount --bind /dev "$debian/dev"
    local machine
    for machine in $MACHINES; do
        inside dpkg --add-architecture "${ARCHITECTURE[$machine]}"
    done
    [[ -e "$debian/updated" ]] || quietly inside apt-get update
    touch "$debian/updated"
    install rustc cargo rust-src gcc libc6-dev
    say "with $(inside rustc --version)"
}

install() {
    inside dpkg --status "$@" >/dev/null 2>&1 || quietly inside apt-get install -y "$@"
}

# Runs a command in that Debian, among the sources.
inside() {
    local folder=/sfera
    [[ -d "$debian$folder" ]] || folder=/
    interruptibly chroot "$debian" env -i --chdir="$folder" PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
        LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive CARGO_HOME=/cargo CARGO_TARGET_DIR=/build \
        CARGO_PROFILE_DEV_DEBUG=0 RUST_BACKTRACE=0 "${environment[@]}" "$@"
}
environment=()

# What a command says is shown only if it fails.
quietly() {
    if ! "$@" >"$work/log" 2>&1; then
        tail -n 40 "$work/log" >&2
        fail "$*"
    fi
}

# The tree as git has it, and this machine's crates, those of the standard library too.
copy_sources() {
    rm -rf "$debian/sfera"
    mkdir -p "$debian/sfera" "$debian/cargo/registry"
    git ls-files -z | grep -zv '^\.cargo/' | xargs -0 tar cf - | tar xf - -C "$debian/sfera"
    cp Cargo.lock "$debian/sfera/tests/everywhere/Cargo.lock"
    local library=$debian/usr/lib/rustlib/src/rust/library
    # Debian's own copies of them are no place for ours.
    rm -rf "$library/.cargo"
    quietly cargo fetch --locked
    RUSTC_BOOTSTRAP=1 quietly cargo fetch --locked --manifest-path "$library/Cargo.toml"
    mount --bind "${CARGO_HOME:-$HOME/.cargo}/registry" "$debian/cargo/registry"
    printf '[net]\noffline = true\n' >"$debian/cargo/config.toml"
}

# --- The pictures of this machine, which all others must draw too.

PICTURES=(cargo build --manifest-path tests/everywhere/Cargo.toml --target)

pictures_of_this_machine() {
    [[ -z "${drawn_here:-}" ]] || return 0
    drawn_here=1
    mkdir -p "$debian/pictures/families"
    quietly inside "${PICTURES[@]}" "$HERE"
    inside "/build/$HERE/debug/everywhere" make /pictures/families
    draw_pictures "$HERE" "/build/$HERE/debug/everywhere" ||
        fail "this machine's own pictures are wrong"
    say "$(wc -l <"$debian/pictures/$HERE") pictures drawn by this machine"
}

# Draws all pictures by a command, and leaves what came of it under a name.
draw_pictures() {
    local name=$1 status=0
    shift
    {
        inside "$@" draw "${SIZE[@]}" scenes/*.txt &&
            inside "$@" draw "${FAMILY_SIZE[@]}" /pictures/families
    } >"$debian/pictures/$name.new" || status=$?
    mv "$debian/pictures/$name.new" "$debian/pictures/$name"
    return "$status"
}

compare_pictures() {
    local machine=$1 name=$2
    shift 2
    draw_pictures "$name" "$@" || fail "$machine: wrong pixels, see above"
    diff "$debian/pictures/$HERE" "$debian/pictures/$name" ||
        fail "$machine: these pictures are not those of $HERE"
    note "$machine: RUN: $(wc -l <"$debian/pictures/$name") pictures by every method, 0 wrong pixels," \
        "the hashes of x86-64"
}

# --- The stages.

stage_emulated() {
    local machine target
    pictures_of_this_machine
    for machine in $MACHINES; do
        target=${TARGET[$machine]}
        prepare_for "$machine"
        quietly inside "${PICTURES[@]}" "$target"
        [[ "$machine" != s390x ]] || without_mdebr "/build/$target/debug/everywhere"
        # shellcheck disable=SC2086 # The runner is several words.
        compare_pictures "$machine" "$target" $runner "/build/$target/debug/everywhere"
    done
    environment=()
}

# An instruction that QEMU 7.2, which many have, executes wrongly: see `spheres::double`.
without_mdebr() {
    local found
    inside s390x-linux-gnu-objdump --disassemble "$1" >"$work/log"
    found=$(grep -cwE 'mdebr?' "$work/log") || true
    ((found == 0)) || fail "s390x: the compiler has made $found instructions MDEBR"
}

stage_tests() {
    local machine skipped
    for machine in $MACHINES; do
        prepare_for "$machine"
        skipped=()
        [[ -z "${EMULATOR[$machine]}" ]] || skipped=("${TOO_SLOW[@]/#/--skip=}")
        say "$machine: the tests of exactness, bit identity and reading"
        quietly inside cargo test --no-default-features --target "${TARGET[$machine]}" \
            "${TESTS[@]}" -- --exact "${skipped[@]}"
        cp "$work/log" "$work/tests-$machine"
        note "$machine: RUN: $(grep -c '^test .* ok$' "$work/log") tests (${TESTS[*]})"
    done
    note "tests: NOT RUN under emulators, which they take too long: ${TOO_SLOW[*]}"
    environment=()
}

# Installs what builds for a machine, and tells cargo how to link and to run.
prepare_for() {
    local machine=$1 tools=${TOOLS[$1]} emulator=${EMULATOR[$1]}
    local library=/usr/$tools/lib variable=${TARGET[$1]^^}
    install "libstd-rust-dev:${ARCHITECTURE[$machine]}" "gcc-$tools" \
        "libc6-dev-${ARCHITECTURE[$machine]}-cross" qemu-user
    runner="$library/ld-linux.so.2 --library-path $library"
    [[ -z "$emulator" ]] || runner="$emulator -L /usr/$tools"
    variable=CARGO_TARGET_${variable//-/_}
    environment=("${variable}_LINKER=$tools-gcc" "${variable}_RUNNER=$runner")
}

# Without lanes of its own, and with them.
stage_wasm() {
    local target=wasm32-wasip1 feature
    pictures_of_this_machine
    install libstd-rust-dev-wasm32 lld nodejs
    for feature in -simd128 +simd128; do
        environment=(CARGO_TARGET_WASM32_WASIP1_LINKER=wasm-ld
            CARGO_TARGET_WASM32_WASIP1_RUSTFLAGS="-Clinker-flavor=wasm-ld -Ctarget-feature=$feature")
        quietly inside "${PICTURES[@]}" "$target"
        environment=()
        compare_pictures "$target, $feature" "$target" node --no-warnings tests/everywhere/wasi.mjs \
            "/build/$target/debug/everywhere.wasm"
    done
}

# With sources the standard library can be built where there is none.
BUILD_STD=(RUSTC_BOOTSTRAP=1)

stage_windows() {
    local target=x86_64-pc-windows-gnu
    pictures_of_this_machine
    install gcc-mingw-w64-x86-64 wine wine64
    environment=("${BUILD_STD[@]}" WINEDEBUG=-all XDG_RUNTIME_DIR=/tmp)
    objects_of_windows "$target"
    quietly inside "${PICTURES[@]}" "$target" -Zbuild-std
    compare_pictures "Windows, by wine" "$target" wine "/build/$target/debug/everywhere.exe"
    quietly inside cargo build --target "$target" -Zbuild-std
    local sfera=(wine "/build/$target/debug/sfera.exe" scenes/example.txt /tmp/image.ppm 640 480)
    rm -f "$debian/tmp/image.ppm"
    quietly inside "${sfera[@]}"
    quietly inside "${sfera[@]}" --rows 10..20
    quietly inside "${sfera[@]}" --verify
    [[ -z "$(inside find /tmp -name '.sfera-*')" ]] || fail "Windows: a temporary file is left"
    note "Windows, by wine: RUN: the program makes an image, draws rows in it and verifies it"
    environment=()
}

# What a program begins and ends with; the sources of the standard library have it apart.
objects_of_windows() {
    local object folder=/usr/lib/rustlib
    mkdir -p "$debian$folder/$1/lib"
    for object in rsbegin rsend; do
        quietly inside rustc --target "$1" --emit=obj -o "$folder/$1/lib/$object.o" \
            "$folder/src/rust/library/rtstartup/$object.rs"
    done
}

stage_checked() {
    local target
    environment=("${BUILD_STD[@]}")
    for target in aarch64-apple-darwin x86_64-unknown-freebsd x86_64-pc-windows-msvc; do
        quietly inside cargo check --target "$target" -Zbuild-std
        note "$target: ONLY CHECKED: library and program compile"
    done
    environment=()
}

# Nothing is read from this file after that, which may change while it runs.
main "$@"; exit
