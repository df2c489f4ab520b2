#!/bin/sh
# Two layers, on a fresh Debian machine: what running needs (gcc, GSL, .venv with pkgen in it), and with
# `tests` also what tests, live pages, films, exports and sanitizers need. System packages come by apt
# where missing; pkgen from the Python registry, and where none can be reached, from Debian's own
# python3-* packages.
#
#   sh tools/setup.sh [tests]
#   PKGEN_SETUP=registry|debian   force one of the two ways
#   PKGEN_PREFIX=DIR              install for use, not for work on it (see `make install`)
set -eu
cd "$(dirname "$0")/.."

way=${PKGEN_SETUP:-any}
if [ -n "${PKGEN_PREFIX:-}" ]; then
    venv=$PKGEN_PREFIX/lib/pkgen
    editable=
    extra='[plot,tables,completion,lsp]'
else
    venv=.venv
    editable=-e
    extra='[plot,tables]'
fi
tests=
[ "${1:-}" != tests ] || tests=yes extra='[dev]'
mkdir -p build
log=build/setup.log
: >"$log"

say() { printf '%s\n' "setup: $*"; }

fail() {
    say "$*" >&2
    [ -s "$log" ] && tail -n 5 "$log" >&2
    exit 1
}

# apt_install PACKAGE...: as root or through sudo; elsewhere says what to install.
updated=no
apt_install() {
    if ! command -v apt-get >/dev/null; then
        fail "please install what these Debian packages hold, then run make again: $*"
    elif [ "$(id -u)" = 0 ]; then
        as_root=
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
        as_root='sudo -n'
    else
        fail "please run, then make again: sudo apt-get install $*"
    fi
    say "installing $*"
    if [ $updated = no ]; then
        $as_root apt-get update >>"$log" 2>&1 || say "apt-get update failed; going on"
        updated=yes
    fi
    $as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y --no-install-recommends "$@" >>"$log" 2>&1 ||
        fail "apt-get install failed (see $log)"
}

has_header() { echo "#include <$1>" | cc -E - >/dev/null 2>&1; }

programs='gcc:gcc ar:binutils'
[ -z "$tests" ] || programs="$programs clang:clang g++:g++"
missing=
for pair in $programs; do
    command -v "${pair%%:*}" >/dev/null || missing="$missing ${pair#*:}"
done
[ -z "$missing" ] || apt_install $missing libc6-dev
missing=
has_header gsl/gsl_odeiv2.h || missing="$missing libgsl-dev"
[ -z "$tests" ] || has_header CUnit/CUnit.h || missing="$missing libcunit1-dev"
[ -z "$missing" ] || apt_install $missing

tests_alone() {
# Lane kernels are also compiled for NEON and run in an emulator; without, that test is skipped.
cross=aarch64-linux-gnu
if [ "$(uname -m)" != aarch64 ]; then
    if ! command -v $cross-gcc >/dev/null || ! command -v qemu-aarch64 >/dev/null; then
        (apt_install gcc-$cross libc6-dev-arm64-cross qemu-user) 2>>"$log" ||
            say "not to be had here: gcc-$cross and qemu-user; NEON will not be tested"
    fi
fi

# The run-time parts of clang's sanitizers and of libFuzzer: make asan, make fuzz.
if ! echo 'int main(void) { return 0; }' | clang -fsanitize=memory -x c - -o /dev/null 2>/dev/null; then
    (apt_install libclang-rt-dev) 2>>"$log" ||
        say "not to be had here: libclang-rt-dev; make asan and make fuzz will leave out what wants it"
fi

# What makes live pages and films: without, `pkgen show` and `pkgen film` say what they lack.
missing=
command -v wasm-ld >/dev/null || missing="$missing lld"
[ -e /usr/lib/wasm32-wasi/libc.a ] || missing="$missing wasi-libc"
find /usr/lib/llvm-*/lib/clang -name '*builtins*wasm32*' 2>/dev/null | grep -q . ||
    missing="$missing libclang-rt-dev-wasm32"
command -v ffmpeg >/dev/null || missing="$missing ffmpeg"
command -v node >/dev/null || missing="$missing nodejs"
[ -z "$missing" ] || (apt_install $missing) 2>>"$log" || say "not to be had here:$missing"

# A browser for the tests of live pages; without, they are skipped.
command -v chromium >/dev/null || (apt_install chromium) 2>>"$log" ||
    say "not to be had here: chromium; pages will not be tested"
}
[ -z "$tests" ] || tests_alone

from_registry() {
    if [ -n "$tests" ] && [ -x "$venv/bin/python" ]; then
        "$venv/bin/python" -m pip install --disable-pip-version-check --retries 1 --timeout 30 \
            $editable ".$extra" >>"$log" 2>&1
        return
    fi
    # Some Debian machines have python3 without venv and pip; those come from apt.
    command -v python3 >/dev/null || apt_install python3 python3-venv
    rm -rf "$venv"
    python3 -m venv "$venv" >>"$log" 2>&1 || {
        apt_install python3-venv
        rm -rf "$venv"
        python3 -m venv "$venv" >>"$log" 2>&1 || return 1
    }
    "$venv/bin/python" -m pip install --disable-pip-version-check --retries 1 --timeout 30 \
        $editable ".$extra" >>"$log" 2>&1
}

from_debian() {
    if [ -n "$tests" ]; then
        apt_install python3-pytest python3-pytest-xdist
        # Of these two some releases have none, or older ones: then these commands say what they lack.
        for package in python3-shtab python3-pygls; do
            (apt_install $package) 2>>"$log" || say "not to be had here: $package"
        done
        [ ! -x "$venv/bin/python" ] || return 0
    fi
    apt_install python3 python3-venv python3-pip python3-setuptools python3-wheel \
        python3-jinja2 python3-lark python3-numpy python3-pint python3-rich python3-sympy \
        python3-matplotlib python3-scipy
    rm -rf "$venv"
    # Debian's own python3: another one that comes first in PATH does not see its packages.
    /usr/bin/python3 -m venv --system-site-packages "$venv" >>"$log" 2>&1 &&
        "$venv/bin/python" -m pip install --disable-pip-version-check --no-index --no-deps \
            --no-build-isolation $editable . >>"$log" 2>&1
}

case $way in
registry) from_registry || fail "installing from the Python registry failed (see $log)" ;;
debian) from_debian || fail "installing from Debian's packages failed (see $log)" ;;
any)
    from_registry || {
        say "no Python registry can be reached; using Debian's python3-* packages"
        from_debian || fail "installing from Debian's packages failed too (see $log)"
    }
    ;;
*) fail "PKGEN_SETUP is registry or debian, not '$way'" ;;
esac

# IPOPT for the tests of `pkgen optimise`: without, they are skipped.
if [ -n "$tests" ] && ! "$venv/bin/python" -c 'import cyipopt' 2>/dev/null; then
    pkg-config --exists ipopt 2>/dev/null ||
        (apt_install pkg-config coinor-libipopt-dev) 2>>"$log" || :
    "$venv/bin/python" -m pip install --disable-pip-version-check --retries 1 --timeout 30 \
        $editable '.[optimise]' >>"$log" 2>&1 || say "not to be had here: cyipopt"
fi

# Where PYTHONDONTWRITEBYTECODE is set, each start would compile a hundred modules again.
"$venv/bin/python" -m compileall -q generator/pkgen >>"$log" 2>&1

"$venv/bin/pkgen" --version >>"$log" 2>&1 || fail "pkgen was installed but does not start (see $log)"
say "ready: $venv/bin/$("$venv/bin/pkgen" --version)"
