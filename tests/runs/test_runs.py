"""Models that say how they are run and what comes out: rows at the head of each file beside this.

    # run: OPTIONS                     arrives, and all that its scene expects is met
    # miss: OPTIONS                    something that its scene expects is missed
    # same 1e-9: OPTIONS || OPTIONS    two runs have the same rows, in which something moves
    # ends 1e-9: OPTIONS || OPTIONS    the same of their last rows alone
    # loops 1e-9: OPTIONS              families as loops and with members written out agree
    # slides 1e-9: OPTIONS             they end alike, on the same switch

`{a,b}` makes a test of each. A row that begins with `long` is for `make test-long`. Lines of a
model that end with `#| a b` are there in rows of tag a or b alone: `# run[a]: OPTIONS`; the tag of
other rows is -. Both sides of `same` may begin with their tag:
`# same 1e-9: [a] OPTIONS || [b] OPTIONS`.
"""

from __future__ import annotations

import csv
import re
import sys
from itertools import product
from pathlib import Path

import pytest

from conftest import ROOT
from pkgen.__main__ import main
from pkgen.compiler import compile_model
from pkgen.source import Source

sys.path.insert(0, str(ROOT / "tests" / "fuzz"))
import families

ROW = re.compile(r"# (long )?(run|miss|same|ends|loops|slides)(?:\[([\w ,]+)\])?(?: (\S+))?: *(.*)")
MODELS = sorted(Path(__file__).parent.glob("*.lag"))


def expanded(text: str) -> list[str]:
    parts = re.split(r"\{([^{}]*)\}", text)
    choices = [part.split(",") if k % 2 else [part] for k, part in enumerate(parts)]
    return ["".join(x) for x in product(*choices)]


def cases() -> list:
    found = []
    for path in MODELS:
        rows = filter(None, map(ROW.fullmatch, path.read_text(encoding="utf-8").splitlines()))
        one = [
            (kind, tag, float(near or 0), words, long)
            for long, kind, tags, near, words in (row.groups() for row in rows)
            for tag in (tags or "-").split(",")
            for words in expanded(words)
        ]
        assert one, f"{path}: it has no row"
        for k, (*row, long) in enumerate(one):
            marks = [pytest.mark.long] * bool(long)
            found.append(pytest.param(path, *row, id=f"{path.stem}-{k}", marks=marks))
    return found


def split(text: str) -> list[str]:
    """By spaces outside of double quotes; a rate ends with a single one."""
    return [word.replace('"', "") for word in re.findall(r'(?:"[^"]*"|\S)+', text)]


def written(path: Path, tag: str, folder: Path) -> Path:
    """The model with the lines of its tag."""
    lines = path.read_text(encoding="utf-8").splitlines()
    kept = [x for x in lines if "#| " not in x or tag in x.split("#| ")[1].split()]
    (folder / path.name).write_text("\n".join(kept) + "\n", encoding="utf-8")
    return folder / path.name


def rows(path: Path) -> list[dict[str, float]]:
    with open(path, encoding="utf-8") as file:
        return [{name: float(x) for name, x in row.items()} for row in csv.DictReader(file)]


def moves(found: list[list[float]]) -> bool:
    return max(abs(a - b) for a, b in zip(found[0][1:], found[-1][1:], strict=True)) > 1e-4


@pytest.mark.parametrize(("path", "kind", "tag", "near", "words"), cases())
def test_it_comes_out_as_it_says(path, kind, tag, near, words, tmp_path, capsys) -> None:
    if kind in ("loops", "slides"):
        model = written(path, tag, tmp_path)
        assert not compile_model(Source(str(model), model.read_text())).equations.dense
        run = ("run", str(model), *split(words))
        answers = families.both(tmp_path, *run)
        assert families.differ(answers, run, near) == ""
        assert answers[0][2]["status"] == ("PK_DONE" if kind == "loops" else "PK_SLIDING")
        assert kind == "slides" or moves(answers[0][1])
        return
    found = []
    for k, options in enumerate(words.split("||")):
        own, options = re.fullmatch(r" *(?:\[(\w+)\])?(.*)", options).groups()
        model, out = written(path, own or tag, tmp_path), tmp_path / f"{k}.csv"
        code = main(["run", str(model), "-o", str(out), *split(options)])
        said = capsys.readouterr().err
        assert code == (4 if kind == "miss" else 0), said
        assert ("expectation missed" in said) == (kind == "miss")
        assert "||" in words or re.search(r"expected: \d+ of \d+ met", said), said
        found.append(rows(out) if "||" in words else [])
    if "||" in words:
        one, other = found
        assert moves([[*row.values()] for row in one])
        one, other = (x[-1:] if kind == "ends" else x for x in found)
        assert len(one) == len(other) > (kind == "same")
        for a, b in zip(one, other, strict=True):
            assert a == pytest.approx(b, rel=near, abs=near)


def test_rows_that_do_not_hold_are_found(tmp_path, capsys) -> None:
    """Of each kind one."""
    path = tmp_path / "m.lag"
    path.write_text(
        "model m\nsize N = 20\ncoord q[1..N], x\nkinetic sum(q[i]'^2, i = 1..N) + x'^2/2\n"
        "potential x^2/2\nstart x = 1\nscene s\n until 1\n expect x = cos(t) within 1e-6\n"
        " expect x' < 1\nend\n"
    )
    given = ("--until 1 --every 1 --method ", "rk4 --step 0.1", "euler --step 0.1")
    for kind, words in (
        ("run", "--scene s --start x=2"),
        ("miss", "--scene s"),
        ("same", f"{given[0]}{given[1]} || {given[0]}{given[2]}"),
        ("same", f"{given[0]}{given[1]} --start x=0 || {given[0]}{given[1]} --start x=0"),
        ("loops", f"{given[0]}{given[1]} --start x=0"),
    ):
        with pytest.raises(AssertionError):
            test_it_comes_out_as_it_says(path, kind, "-", 1e-9, words, tmp_path, capsys)
