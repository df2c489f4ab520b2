#!/bin/sh
# The Debian package, of a copy of what git tracks: build/dist/pkgen_VERSION_all.deb, lintian clean.
# What builds it comes by apt where it is missing, as root or with sudo.
set -eu
cd "$(dirname "$0")/../.."
root=$PWD
version=$(sed -n 's/^__version__ = "\(.*\)"/\1/p' generator/pkgen/version.py)
log=$root/build/deb.log

fail() {
    echo "deb: $*" >&2
    exit 1
}

mkdir -p build/dist
dpkg-checkbuilddeps 2>/dev/null && command -v lintian >/dev/null || {
    command -v apt-get >/dev/null || fail "a Debian package is built on Debian alone"
    as_root=
    [ "$(id -u)" = 0 ] || as_root='sudo -n'
    echo "deb: installing what builds it"
    $as_root apt-get update >"$log" 2>&1 || true
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        dpkg-dev lintian >>"$log" 2>&1 &&
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get build-dep -y --no-install-recommends ./ >>"$log" 2>&1 ||
        fail "please run: sudo apt-get install dpkg-dev lintian && sudo apt-get build-dep ./  (see $log)"
}

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
tree=$folder/pkgen-$version
mkdir "$tree"
git ls-files -z | grep -zvE '^(docs/pictures|tests|bench|tools|editors)/' |
    tar --null --no-recursion -T - -c | tar -x -C "$tree"
# Debian's own python3: another one in PATH does not see its packages.
(cd "$tree" && PATH=/usr/sbin:/usr/bin:/sbin:/bin dpkg-buildpackage -us -uc -b) >"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    fail "dpkg-buildpackage failed (see $log)"
}
lintian --fail-on error,warning --info "$folder"/pkgen_*.changes || fail "lintian found something"
cp "$folder"/pkgen_*.deb build/dist/
echo "build/dist/pkgen_${version}_all.deb"
