#!/bin/sh
# Usage: symbols.sh libpk.a libpk_gsl.a. What the libraries export and what they use.
set -eu
core=$1 gsl=$2
fail() { echo "symbols: $1" >&2; exit 1; }

exported=$(nm -g --defined-only "$core" "$gsl" | awk 'NF == 3 {print $3}')
[ "$(echo "$exported" | wc -l)" -ge 20 ] || fail "hardly any exported symbol: is the list empty?"
bad=$(echo "$exported" | grep -v -e '^pk_' -e '^__asan' -e '^__odr_asan' || true)
[ -z "$bad" ] || fail "exported without the prefix pk_: $bad"

used=$(nm -u "$core" | awk 'NF == 2 {print $2}')
echo "$used" | grep -q '^mem' || fail "no use of memcpy seen: is the list empty?"
bad=$(echo "$used" | grep -E '^(malloc|calloc|realloc|free|aligned_alloc|printf|puts|putchar|fprintf|exit|abort|gsl_.*)$' || true)
[ -z "$bad" ] || fail "libpk.a must not use: $bad"
nm -u "$gsl" | grep -q 'gsl_odeiv2' || fail "libpk_gsl.a uses no gsl_odeiv2: the check is blind"
echo "symbols: all exported are pk_*; the core uses no malloc, stdio output, exit or GSL"
