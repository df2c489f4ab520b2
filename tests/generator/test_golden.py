"""The C of two models under version control shows every change of the output: a plain one to be
embedded, and one of the runtime with families as loops.

After a wanted change: PKGEN_UPDATE=1 pytest tests/generator/test_golden.py  (make golden)
"""

import os
from pathlib import Path

import pytest
from c_harness import ROOT

from pkgen.back.kernels import PLAIN
from pkgen.compiler import compile_model
from pkgen.source import Source

GOLDEN = ROOT / "tests" / "golden"
NAMES = {
    "double_pendulum": {"plain": True, "kernels": PLAIN},
    "chains/fput": {},
}


def files_of(name: str) -> dict[str, str]:
    path = ROOT / "models" / f"{name}.lag"
    return compile_model(Source(path.name, path.read_text(encoding="utf-8")), **NAMES[name]).files


@pytest.mark.parametrize("name", NAMES)
def test_golden(name):
    files = files_of(name)
    for file, text in files.items():
        kept = GOLDEN / file
        if os.environ.get("PKGEN_UPDATE"):
            kept.write_text(text, encoding="utf-8")
        assert kept.exists(), f"{kept} is missing; {_update()}"
        assert kept.read_text(encoding="utf-8") == text, (
            f"{file} has changed; if meant, {_update()}"
        )


def test_nothing_else_is_kept():
    wanted = {file for name in NAMES for file in files_of(name)}
    assert {p.name for p in GOLDEN.iterdir()} == wanted


def _update() -> str:
    return f"PKGEN_UPDATE=1 pytest {Path(__file__).relative_to(ROOT)}"
