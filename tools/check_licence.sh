#!/bin/sh
# GSL is GPL: only runtime/gsl may include it or link it (and bench/, whose programs, peers of
# pkgen, are made to be timed and never leave the machine). The core, the driver without
# PK_WITH_GSL, and everything that pkgen emits must not.
set -eu
cd "$(dirname "$0")/.."
status=0

outside=$(grep -rlE '#[[:space:]]*include[[:space:]]*[<"]gsl/' runtime generator models tests \
    --include='*.[ch]' --include='*.j2' 2>/dev/null | grep -v '^runtime/gsl/' || true)
if [ -n "$outside" ]; then
    echo "licence: GSL is included outside runtime/gsl: $outside" >&2
    status=1
fi

# Symbols say the same of what was compiled.
for library in build/runtime/libpk.a; do
    if [ -f "$library" ] && nm -u "$library" 2>/dev/null | grep -q ' gsl_'; then
        echo "licence: $library refers to GSL" >&2
        status=1
    fi
done
[ $status = 0 ] && echo "licence: GSL stays in runtime/gsl"
exit $status
