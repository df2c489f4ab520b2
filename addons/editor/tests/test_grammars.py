"""The grammars of editors are made of the words of the language, and colour as the lexer reads."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from colours import TextMate, by_emacs, by_lexer, by_vim, differences, grammar

from conftest import PAGES, ROOT
from pkgen.front.joints import KINDS
from pkgen.front.shapes import SHAPES
from pkgen.front.table import STATEMENTS
from pkgen_editor.words import built_in, calls, words

BODIES = """model arm
size N = 3
body link[1..N] mass 1 [kg] at [0, 0, 0.5 [m]]   # links
joint j[i = 2..N]: link[i-1] to link[i] revolute [0, 1, 0] at [0, 0, 1 [m]]
joint k: ground to link[1] spherical turned rot([1, 0, 0], 2 [deg])
gravity [0, 0, -9.81]
method mine tableau some/file.tab
param θ2 = 3.5e-3[rad] in [-1, 1)
let fast = step(θ2) + (q[1] +
    θ2)[m]
observe p = link[N].com.x*t
record j[2]' every 0.1 [s] at hit
"""


def texts() -> list[tuple[str, str]]:
    """Models of the collection, of the docs, and one of what these do not have."""
    files = [*(ROOT / "models").rglob("*.lag"), *(ROOT / "tests/models").rglob("*.lag")]
    found = [(path.name, path.read_text(encoding="utf-8")) for path in sorted(files)]
    for page in PAGES:
        blocks = re.findall(r"^```lag\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)
        found += [(page.name, block) for block in blocks]
    return [*found, ("bodies", BODIES)]


def every_word() -> str:
    """Each word of the language where it is one."""
    lines = [row.form for row in STATEMENTS.values()]
    lines += [f"let a = {name}(b)" for name in words()["function"]]
    lines += [shape.form for shape in SHAPES.values()]
    lines += [f"draw body R at P {form} [a, b]" for form in ("box", "cylinder", "disk", "top")]
    lines += [f"joint a: ground to b {kind}" for kind in KINDS]
    return "\n".join([*lines, *(f"let b = 2*{name}" for name in words()["constant"]), ""])


def test_the_files_are_what_the_generator_makes() -> None:
    command = [sys.executable, ROOT / "tools/editors", "--check"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, ""), "run python tools/editors"


def test_each_function_has_its_sentence() -> None:
    assert set(calls()) == set(words()["function"]) and len(calls()) > 25
    assert all(what and form.startswith(name) for name, (form, what) in calls().items())
    assert set(words()["constant"]) <= set(built_in())


def test_a_difference_is_seen() -> None:
    text = "param m = 1 [kg]\n"
    assert by_lexer(text)[12] == "unit"
    assert differences(text, ["statement"] * 5 + [""] * 12)[0] == "1:11: number, not -: 1 [kg]"


def test_textmate() -> None:
    engine = TextMate(grammar())
    for name, text in [("words", every_word()), *texts()]:
        assert differences(text, engine.colour(text)) == [], name


@pytest.mark.parametrize(
    ("colour", "same"), [(by_vim, {}), (by_emacs, {"shape": "unit", "number": ""})]
)
def test_vim_and_emacs(colour: Callable, same: dict[str, str], tmp_path: Path) -> None:
    given = [every_word(), *(text for _, text in texts())]
    coloured = colour(given, tmp_path)
    if coloured is None:
        pytest.skip("not here, or without colours")
    for text, kinds in zip(given, coloured, strict=True):
        assert differences(text, kinds, same) == []
