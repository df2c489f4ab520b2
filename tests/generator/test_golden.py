"""Five models' C, one with its families as loops, one with events, kept under version control so
that every change of the output is seen.

After a wanted change: PKGEN_UPDATE=1 pytest tests/generator/test_golden.py  (make golden)
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from c_harness import MODELS, ROOT, read_model
from pkgen.back.c.render import render
from pkgen.compiler import compile_model
from pkgen.source import Source

GOLDEN = ROOT / "tests" / "golden"
UNROLLED = ("coupled_oscillators", "double_pendulum", "heavy_top")
LOOPED = ("fput",)
WITH_EVENTS = ("thrown_stone",)
NAMES = UNROLLED + LOOPED + WITH_EVENTS


def files_of(name: str) -> dict[str, str]:
    if name in LOOPED:
        path = ROOT / "models" / "chains" / f"{name}.lag"
        return compile_model(Source(path.name, path.read_text(encoding="utf-8"))).files
    if name in WITH_EVENTS:
        return render(read_model(ROOT / "models" / "particles" / f"{name}.lag")[1])
    _, program = read_model(next(p for p in MODELS if p.stem == name))
    return render(program)


@pytest.mark.parametrize("name", NAMES)
def test_golden(name):
    files = files_of(name)
    assert set(files) == {f"{name}.h", f"{name}.c"}
    for file, text in files.items():
        kept = GOLDEN / file
        if os.environ.get("PKGEN_UPDATE"):
            kept.write_text(text, encoding="utf-8")
        assert kept.exists(), f"{kept} is missing; {_update()}"
        assert kept.read_text(encoding="utf-8") == text, (
            f"{file} has changed; if meant, {_update()}"
        )


def test_nothing_else_is_kept():
    wanted = {f"{name}.{suffix}" for name in NAMES for suffix in "ch"}
    assert {p.name for p in GOLDEN.iterdir()} == wanted


def _update() -> str:
    return f"PKGEN_UPDATE=1 pytest {Path(__file__).relative_to(ROOT)}"
