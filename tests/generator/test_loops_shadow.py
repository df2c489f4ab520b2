"""The C of families with rows of constraints declares no name twice."""

import subprocess

from conftest import STRICT
from pkgen.compiler import compile_model
from pkgen.source import Source

ROPE = """\
model rope
size N = 100
coord x[1..N], y[1..N]
fixed x[0] = 0, y[0] = 0
kinetic sum((x[i]'^2 + y[i]'^2)/2, i = 1..N)
potential sum(9.81*y[i], i = 1..N)
constraint rod[i = 1..N]: (x[i] - x[i-1])^2 + (y[i] - y[i-1])^2 = 1
start x[i = 1..N] = i
"""


def test_rope_of_rods(tmp_path):
    for name, text in compile_model(Source("rope.lag", ROPE)).files.items():
        (tmp_path / name).write_text(text)
    command = ["gcc", *STRICT, "-Wshadow", "-fsyntax-only", "rope.c"]
    subprocess.run(command, cwd=tmp_path, check=True)
