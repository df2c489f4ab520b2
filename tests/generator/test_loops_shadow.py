"""The C of families with rows of constraints declares no name twice."""

import subprocess

from conftest import STRICT, case
from pkgen.compiler import compile_model
from pkgen.source import Source

ROPE = case("loops_shadow_rope")


def test_rope_of_rods(tmp_path):
    for name, text in compile_model(Source("rope.lag", ROPE)).files.items():
        (tmp_path / name).write_text(text)
    command = ["gcc", *STRICT, "-Wshadow", "-fsyntax-only", "rope.c"]
    subprocess.run(command, cwd=tmp_path, check=True)
