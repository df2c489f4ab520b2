"""`pkgen fmt`: a text says the same in its layout, whatever its spaces were; and is then left as it
is."""

from __future__ import annotations

import json
import os
import random
import re
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT, long_but, run_pkgen
from pkgen.compiler import compile_model
from pkgen.front.lexer import statements
from pkgen.front.read import USE
from pkgen.source import ModelError, Source
from pkgen_editor.layout import laid_out, signs
from pkgen_editor.look import Text

MODELS = sorted([*(ROOT / "models").rglob("*.lag"), *(ROOT / "tests/models").rglob("*.lag")])


def of(text: str) -> Source:
    return Source("m.lag", text, dotted=USE.search(text) is not None)


def comments(text: str) -> list[str]:
    text = re.sub(r'"[^"\n]*"', '""', text)  # a sign in a string begins no comment
    return [found.rstrip() for found in re.findall("#.*", text)]


def respaced(source: Source, rng: random.Random) -> str:
    """The same tokens in other spaces: lines broken within brackets, comments put there, indices
    left touching and units not."""
    text, made, at, depth = source.text, [], 0, 0
    for statement in statements(source):
        for token, after in zip(statement.tokens, [*statement.tokens[1:], None], strict=True):
            made += [text[at : token.start_pos], text[token.start_pos : token.end_pos]]
            at = token.end_pos
            depth += token.type in ("LPAREN", "LINDEX", "LVECTOR", "LEND")
            depth -= token.type in ("RPAREN", "RBRACKET", "REND")
            if after is None or after.type in ("LINDEX", "FILE"):
                continue
            gap = text[at : after.start_pos]
            if gap.strip(" ") == "" and (gap or token.type == "_COMMA" or depth):
                choices = [gap or " ", gap + " ", "\t "]
                if depth:
                    choices += ["\n", " # why\n\n   # so\n"]
                made.append(rng.choice(choices))
                at = after.start_pos
    made.append(text[at:])
    lines = "".join(made).split("\n")
    for i in range(len(lines)):
        lines[i] += rng.choice(["", "", "  ", "\t"])
    return "\n".join(lines) + rng.choice(["", "\n\n\n", "  \n"])


def check(text: str) -> str:
    """Its layout, which says what the text says and is its own layout."""
    made = laid_out(of(text))
    assert signs(of(made)) == signs(of(text))
    assert comments(made) == comments(text)
    assert laid_out(of(made)) == made
    assert not re.search(r"[ \t]$|\n\n\n", made, re.MULTILINE)
    return made


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_models(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    made = check(text)
    assert len(made.splitlines()) == len(text.rstrip().splitlines())
    rng = random.Random(path.stem)
    for _ in range(3):
        other = respaced(of(text), rng)
        if "# why" not in other:
            assert signs(of(other)) == signs(of(text))
        check(other)


PIECES = (*"()[]#'+-*1,=\"\\θ", "**", "..", ".x", "e5", "[m]")


@pytest.mark.parametrize("seed", long_but(range(5), range(200)))
def test_mutated_texts_keep_what_they_say_or_are_refused(seed: int) -> None:
    rng = random.Random(seed)
    text = rng.choice(MODELS).read_text(encoding="utf-8")
    pieces = [
        "\n",
        "  ",
        "\t",
        " end ",
        " scene a ",
        " draw bob ",
        " in ",
        " let ",
        " joint ",
        *PIECES,
    ]
    for _ in range(40):
        mutated = text
        for _ in range(rng.randint(1, 6)):
            at = rng.randrange(len(mutated))
            mutated = mutated[:at] + rng.choice(pieces) + mutated[at + rng.randint(0, 3) :]
        try:
            laid_out(of(mutated))
        except ModelError as error:
            assert error.diagnostics
            continue
        check(mutated)


def in_c(text: str) -> dict[str, str]:
    files = compile_model(of(text)).files
    return {name: re.sub(r"[0-9a-f]{64}", "SHA", code) for name, code in files.items()}


@pytest.mark.parametrize("stem", ["double_pendulum", "chaplygin_sleigh", "heavy_top_rotation"])
def test_the_c_is_the_same(stem: str) -> None:
    (path,) = (path for path in MODELS if path.stem == stem)
    text = path.read_text(encoding="utf-8")
    assert in_c(laid_out(of(text))) == in_c(text)


SHAPE = """\
model shape  # which
param m=1[kg]in(0,inf)# a
param length   =  2 [m]   in (0,inf) # b


coord q[ 1..3 ],x [m]
kinetic m/2 * ( x'^ 2 ) +sum( q[i+1]'^2 , i=1 .. N - 1)
potential -x+ - 2*a
scene a
until 3
# a word
method rk4 step .5
expect x=(1+
2*(3
-4))
end
"""


def test_the_layout() -> None:
    with pytest.raises(ModelError, match="error:"):
        laid_out(of(SHAPE))
    assert (
        laid_out(of(SHAPE.replace("step .5", "step 0.5")))
        == """\
model shape                       # which
param m = 1 [kg] in (0, inf)      # a
param length = 2 [m] in (0, inf)  # b

coord q[1..3], x [m]
kinetic   m/2*(x'^2) + sum(q[i+1]'^2, i = 1..N-1)
potential -x + -2*a
scene a
  until 3
  # a word
  method rk4 step 0.5
  expect x = (1 +
              2*(3
                 - 4))
end
"""
    )


COLUMNS = """\
model columns
size  N =  3
param mass  =  2 [kg]      in (0, inf)
# between, a column ends
param l =  1 [m]         in (0, inf)  # near
param J = 20 [kg*m^2]    in (0, inf)  # here
param name = sqrt(l/(9.81 [m/s^2]))  # not so
let x1 =   l*sin(q)
let y1 =  -l*cos(q)
let far = x1
joint hip:    ground  to upper revolute [0, -1, 0]
joint knee:   upper   to lower revolute [0, -1, 0] at [0, 0, -l]
"""


def test_columns_of_the_author_stay_as_far_left_as_they_go() -> None:
    assert (
        check(COLUMNS)
        == """\
model columns
size  N = 3
param mass = 2 [kg] in (0, inf)
# between, a column ends
param l =  1 [m]      in (0, inf)     # near
param J = 20 [kg*m^2] in (0, inf)     # here
param name = sqrt(l/(9.81 [m/s^2]))   # not so
let x1 =  l*sin(q)
let y1 = -l*cos(q)
let far = x1
joint hip:  ground to upper revolute [0, -1, 0]
joint knee: upper  to lower revolute [0, -1, 0] at [0, 0, -l]
"""
    )


def test_comments_stand_where_most_do() -> None:
    text = """\
param first = 1 + 2 + 3 + 4   # sticks out
param a = 1          # these
param b = 2          # are most
param longer_name = 1000  # and this
param c = 3          # in a column
param d = 4     # but this
param e = 5          # now
"""
    made = text.replace("# and this", "    # and this").replace("4     #", "4          #")
    assert check(text) == made


def test_comments_of_half_do_not_move_the_others() -> None:
    text = "param a = 1   # the first\nparam b = 2      # this\nparam c = 3      # and this\n"
    text += "param longer_than_these = 4    # two of four are no majority\n"
    lines = check(text).splitlines()
    assert [line.index("#") for line in lines] == [14, 14, 14, 31]


def test_stars_stay_apart() -> None:
    assert laid_out(of("let a = x* *y\nlet b = x**y\n")) == "let a = x* *y\nlet b = x**y\n"


def test_a_filter_passes_on_what_is_laid_out_already() -> None:
    text = "model a\ncoord x\n"
    command = [sys.executable, "-m", "pkgen", "fmt", "-"]
    done = subprocess.run(command, input=text, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, text, "")


def test_the_models_are_in_their_layout() -> None:
    done = run_pkgen("fmt", "--check", *(ROOT / "models").rglob("*.lag"))
    assert (done.returncode, done.stderr) == (0, "")


def test_in_place_and_not_at_all(write, tmp_path: Path) -> None:
    path = write("model   a\ncoord x\nkinetic   x'^2/2\n")
    path.chmod(0o640)
    done = run_pkgen("fmt", "--check", path)
    assert done.returncode == 1 and f"{path}: not in its layout" in done.stderr
    assert path.read_text().startswith("model   a")
    assert run_pkgen("fmt", "--check", path, path).stderr.count("not in its layout") == 1
    assert (run_pkgen("fmt", path).returncode, path.stat().st_mode & 0o777) == (0, 0o640)
    assert path.read_text() == "model a\ncoord x\nkinetic x'^2/2\n"
    before = os.stat(path)
    done = run_pkgen("fmt", path, "--json")
    assert json.loads(done.stdout) == {"changed": [], "diagnostics": []}
    assert os.stat(path) == before or os.stat(path).st_ino == before.st_ino
    assert run_pkgen("fmt", "--check", path).returncode == 0
    wrong = write("model  b\nparam $ = 1\n")
    done = run_pkgen("fmt", wrong, path, tmp_path / "no.lag")
    assert done.returncode == 2 and f"{wrong}:2:7: error: '$'" in done.stderr
    assert "no such file" in done.stderr and wrong.read_text() == "model  b\nparam $ = 1\n"
    assert sorted(tmp_path.iterdir()) == [path, wrong]


def test_line_ends_become_those_of_the_language(tmp_path: Path) -> None:
    path = tmp_path / "a.lag"
    path.write_bytes(b"\xef\xbb\xbfmodel a\r\ncoord x\r\n")
    assert run_pkgen("fmt", path).returncode == 0
    assert path.read_bytes() == b"model a\ncoord x\n"


def test_the_page_shows_what_happens() -> None:
    page = (ROOT / "addons/editor/README.md").read_text()
    before, after, hover = re.findall(r"^```text\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert laid_out(of(before)) == after
    model = (
        "model a\nparam g = 9.81 [m/s^2]\nparam l = 2 [m]\nparam w = sqrt(g/l)  # of small swings\n"
    )
    text = Text("a.lag", model)
    said = text.hover(model.index("w ="))[1]
    assert said == f"{hover}\n```lag\nparam w = sqrt(g/l)\n```"
