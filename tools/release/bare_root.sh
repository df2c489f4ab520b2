#!/bin/sh
# A minimal Debian in a folder, with these packages and nothing of ours: where what pkgen needs of a
# machine is tried. As root: chroot DIR. Ends with 77 where it cannot be made here.
#
#   sh tools/release/bare_root.sh DIR PACKAGE...
set -eu
directory=$1
shift

skip() {
    echo "bare_root: $*" >&2
    exit 77
}
[ "$(id -u)" = 0 ] || skip "chroot needs root"
command -v mmdebstrap >/dev/null || skip "there is no mmdebstrap; apt-get install mmdebstrap"
. /etc/os-release
sources=
for file in /etc/apt/sources.list /etc/apt/sources.list.d/debian.sources; do
    [ -s "$file" ] && sources="$sources $file"
done
mmdebstrap --variant=minbase --include="$(echo "$@" | tr ' ' ',')" "$VERSION_CODENAME" "$directory" \
    $sources >&2 || skip "packages of $VERSION_CODENAME cannot be had"
