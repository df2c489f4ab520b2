#!/bin/sh
# A quick set of the generator's tests on Debian's own python3 and packages, whatever `make setup` has
# taken: SymPy, lark and Jinja2 are older there. Where they are missing and apt cannot install them,
# it says so and passes.
set -eu
cd "$(dirname "$0")/.."

python=/usr/bin/python3
needed='lark jinja2 sympy numpy pint pytest xdist'
packages='python3-jinja2 python3-lark python3-numpy python3-pint python3-pytest python3-pytest-xdist
    python3-rich python3-sympy'

there() { "$python" -c "import $(echo $needed | tr ' ' ',')" 2>/dev/null; }

if ! there; then
    [ "$(id -u)" = 0 ] && as_root= || as_root='sudo -n'
    if ! command -v apt-get >/dev/null ||
        ! $as_root apt-get install -y --no-install-recommends python3 $packages \
            >build/debian.log 2>&1 || ! there; then
        echo "test-debian: skipped, for Debian's python3 packages cannot be installed here"
        exit 0
    fi
fi
folder=build/debian
rm -rf $folder
mkdir -p $folder
ln -s "$PWD/generator/pkgen" $folder/pkgen
ln -s "$PWD/runtime" $folder/pkgen_runtime
"$python" -c 'import sympy, sys; print("Python", sys.version.split()[0], "SymPy", sympy.__version__)'
cd tests/generator
PYTHONPATH="$OLDPWD/$folder" exec "$python" -m pytest -q -n 2 -p no:cacheprovider -m 'not long' \
    test_golden.py test_wrong_models.py test_parse.py test_differentiate.py test_balls.py \
    test_singularities.py test_derive.py test_reduce.py test_proofs.py
