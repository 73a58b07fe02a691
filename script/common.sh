# common.sh: what demo, test and bench share. Sourced; sets up all that the project needs on Debian 12.
# shellcheck shell=bash
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root" # cmake looks for its presets here

say() { printf '%s\n' "$*" >&2; }
die() { say "$*"; exit 1; }

# What the daemon, its client library and the tools are built from.
packages_build=(cmake ninja-build gcc g++ libc6-dev pkg-config cyclonedds-dev cyclonedds-tools liblcm-dev liblcm-bin
    libglib2.0-dev libsystemd-dev libccd-dev libqhull-dev libssl-dev openssl
    libassimp-dev libxml2-dev libcyaml-dev libpng-dev libwebsockets-dev zlib1g-dev
    iproute2 util-linux python3)
# What the Python package is built from, and needs.
packages_python=(python3-cffi python3-dev python3-numpy python3-setuptools python3-wheel)
# What the page of collided-web is built with. An installed node, of whatever origin, has npm, or brings it.
packages_web=(clang-14 lld-14 wasi-libc libclang-rt-dev-wasm32)
command -v node >/dev/null || packages_web+=(nodejs)
command -v npm >/dev/null || packages_web+=(npm)
# What the tests and benchmarks need beside it.
packages_test=(libcmocka-dev libjson-c-dev libgmp-dev libmpfr-dev python3-gmpy2 clang-14 libclang-rt-14-dev clang-tidy-14
    clang-format-14 procps man-db groff bsdextrautils bash-completion systemd lintian debootstrap dpkg-dev binutils file
    iptables librsvg2-bin buildah podman runc python3-yaml gnuplot-nox libfastrtps-dev gcc-aarch64-linux-gnu libc6-dev-arm64-cross
    qemu-user-static docker-compose locales abigail-tools "${packages_python[@]}" mypy "${packages_web[@]}" chromium)

# quietly WHAT COMMAND...: the command's output is shown only if it fails.
quietly() {
    local what=$1 log
    shift
    log=$(mktemp)
    say "$what"
    if ! "$@" >"$log" 2>&1; then
        tail -n 60 "$log" >&2
        rm -f "$log"
        die "failed: $what"
    fi
    rm -f "$log"
}

# install_packages NAME...: only what is missing, so that a second run is quick.
install_packages() {
    local missing=() name as_root=()
    for name in "$@"; do
        [[ $(dpkg-query -W -f='${Status}' "$name" 2>/dev/null) == 'install ok installed' ]] || missing+=("$name")
    done
    [ ${#missing[@]} -eq 0 ] && return
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || die "missing packages: ${missing[*]}; run once as root, or install sudo"
        as_root=(sudo)
    fi
    # shellcheck disable=SC2016
    quietly "installing ${missing[*]}" "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive sh -c \
        'apt-get -qq update && apt-get -qq -o DPkg::Lock::Timeout=120 install -y --no-install-recommends "$@"' \
        sh "${missing[@]}"
}

# build PRESET [cmake options...]: into build/PRESET.
build() {
    quietly "configuring $1" cmake -S . -B "build/$1" --preset "$1" -DBUILD_TESTING=ON "${@:2}"
    quietly "building $1" cmake --build --preset "$1"
}
