#!/bin/sh
# Usage: symbols.sh DIRECTORY of the libraries. What the libraries export and what they use.
set -eu
core=$1/libpk.a gsl=$1/libpk_gsl.a
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
# A shared library shows what the headers declare, no more and no less.
shown=$(nm -D --defined-only "$1/libpk.so" "$1/libpk_gsl.so" | awk 'NF == 3 {print $3}')
[ "$(echo "$shown" | wc -l)" -ge 90 ] || fail "hardly any function is shown"
declared=$(cat runtime/include/pk/*.h runtime/include/pk/step/*.h)
for symbol in $shown; do
    case $symbol in
    pk_method_* | pk_scalar_is_*) ;; # declared by a macro
    *) echo "$declared" | grep -q "\b$symbol\b" || fail "shown, but in no header: $symbol" ;;
    esac
done
bad=$(nm -D --undefined-only "$1/libpk.so" | grep -i gsl || true)
[ -z "$bad" ] || fail "libpk.so must not use GSL: $bad"
echo "symbols: $(echo "$shown" | wc -l) shown, each in a header;" \
    "$(nm -g --defined-only "$core" "$gsl" | awk 'NF == 3' | wc -l) in the archives"
echo "symbols: all exported are pk_*; the core uses no malloc, stdio output, exit or GSL"
