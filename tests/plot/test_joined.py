"""Rows are joined by lines where these are near the motion; else the plot has denser rows, or
points and a word."""

import json
import math
import random
from pathlib import Path

import pytest

from conftest import ran, seeds

SWING = "model swing\ncoord x\nkinetic x'^2/2\npotential {}\nstart x = {}\n"
WORD = "too far apart in time to be joined"
NEAR = 8  # rows of a period


def drawn(pkgen, *words: object) -> tuple[list[dict], str]:
    done = ran("plot", *words, "--json", "-o", "picture.svg")
    made = json.loads(done.stdout)
    return [line for panel in made["panels"] for line in panel["lines"]], " ".join(made["notes"])


@pytest.mark.parametrize("seed", seeds(range(3), 37))
def test_lines_follow_the_motion(pkgen, write, tmp_path: Path, monkeypatch, seed: int) -> None:
    monkeypatch.chdir(tmp_path)
    dice = random.Random(seed)
    period, until = 10 ** dice.uniform(-2, 2), 10 ** dice.uniform(0, 4)
    rate = 2 * math.pi / period
    linear = f"({rate!r})^2*x^2/2", "1"
    other = f"-({rate!r})^2*cos(x)", "0.1"  # of the same period, and not exact
    text = SWING.format(*dice.choice((linear, other)))
    words = [write(text), "--until", until]
    if dice.random() < 0.4:  # of a whole number of periods too, as a stroboscope has them
        words += ["--every", min(until / 10, period * dice.choice((0.05, 0.4, 1, 3, 0.37)))]
    views = ([], ["--phase", "x,x'"])
    lines, notes = drawn(pkgen, *words, "--method", "gauss", *dice.choice(views))
    for line in lines:
        near = line["points"] * period / until >= 0.9 * NEAR
        assert near or (line["kind"] == "points" and WORD in notes), (line, period, until, words)
    if all(line["kind"] == "line" for line in lines):
        assert WORD not in notes


def test_rows_of_a_file_are_points(pkgen, write, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = write(SWING.format("x^2/2", "1"))
    assert pkgen("run", path, "--until", 100, "--every", 1.9, "-o", "rows.csv").returncode == 0
    for has_its_report in (True, False):
        if not has_its_report:
            Path("rows.csv.json").unlink(missing_ok=True)
            Path("rows.json").unlink(missing_ok=True)
        lines, notes = drawn(pkgen, "rows.csv")
        assert {line["kind"] for line in lines} == {"points"} and WORD in notes
