# common.sh: what demo, test and bench share. Sourced; sets up all that the project needs on Debian 12.
# shellcheck shell=bash
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '%s\n' "$*" >&2; }
die() { say "$*"; exit 1; }

# What the daemon, its client library and the tools are built from.
packages_build=(cmake ninja-build gcc g++ libc6-dev pkg-config cyclonedds-dev cyclonedds-tools liblcm-dev liblcm-bin
    libglib2.0-dev libccd-dev libqhull-dev libassimp-dev libxml2-dev libcyaml-dev iproute2 util-linux python3)
# What the tests and benchmarks need beside it.
packages_test=(libcmocka-dev libjson-c-dev libgmp-dev libmpfr-dev clang-14 libclang-rt-14-dev clang-tidy-14
    clang-format-14 procps)

# install_packages NAME...: only what is missing, so that a second run is quick.
install_packages() {
    local missing=() name as_root=()
    for name in "$@"; do
        dpkg-query -W -f='${Status}' "$name" 2>/dev/null | grep -q 'install ok installed' || missing+=("$name")
    done
    [ ${#missing[@]} -eq 0 ] && return
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || die "missing packages: ${missing[*]}; run once as root, or install sudo"
        as_root=(sudo)
    fi
    say "installing: ${missing[*]}"
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -qq >&2
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2
}

# build PRESET [cmake options...]: into build/PRESET; quiet unless it fails.
build() {
    local preset=$1 log
    shift
    log=$(mktemp)
    say "building $preset"
    if ! { cmake -S "$root" -B "$root/build/$preset" --preset "$preset" "$@" && cmake --build --preset "$preset"; } \
        >"$log" 2>&1; then
        tail -n 60 "$log" >&2
        rm -f "$log"
        die "building $preset failed"
    fi
    rm -f "$log"
}
