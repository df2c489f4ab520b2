"""Pictures in a terminal."""

import io
import re
import subprocess
import sys
from pathlib import Path

import numpy
import pytest
from rich.console import Console

from conftest import ROOT, ran, run_pkgen
from pkgen.plot import compose, terminal
from pkgen.plot.table import Table, read
from pkgen.plot.view import View

PENDULUM = ROOT / "models/pendulums/pendulum.lag"


@pytest.fixture
def table(tmp_path: Path) -> Table:
    t = numpy.linspace(0, 1, 101)
    path = tmp_path / "rows.csv"
    data = numpy.column_stack([t, t, 1 - t])
    numpy.savetxt(path, data, delimiter=",", header="t [s],theta1 [m],b [m]", comments="")
    return read(str(path))


def shown(
    table: Table, columns: str, colour: bool, encoding: str = "utf-8", width: int = 80
) -> str:
    file = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    console = Console(
        file=file,
        width=width,
        height=30,
        force_terminal=colour,
        highlight=False,
        color_system="standard" if colour else None,
        legacy_windows=False,
    )
    view = View("time", tuple((name,) for name in columns.split(",")))
    terminal.show(compose.picture(view, [table]), console)
    file.seek(0)
    return file.read()


def test_a_rising_line_rises(table: Table) -> None:
    lines = shown(table, "theta1", False).splitlines()
    assert lines[0] == "θ₁ [m]" and "t [s]" in lines[-1]
    rows = [line[11:] for line in lines[1:-2]]
    places = [min(k for k, c in enumerate(row) if c != " ") for row in rows if row.strip()]
    assert len(places) == len(rows) > 15 and places == sorted(places, reverse=True)
    assert places[-1] == 0 and places[0] > 60
    assert max(map(len, lines)) <= 80 and "1" in lines[1][:11] and "0" in lines[-3][:11]


def test_lines_are_told_apart_by_colours_or_by_marks(table: Table) -> None:
    coloured = shown(table, "theta1,b", True)
    assert len(set(re.findall(r"\x1b\[(\d+)m[\u2801-\u28ff]", coloured))) == 2
    plain = shown(table, "theta1,b", False)
    assert "\x1b" not in plain and "* θ₁" in plain and "+ b" in plain
    assert plain.count("*") > 20 and plain.count("+") > 20


def test_nothing_but_ascii_where_there_is_no_more(table: Table) -> None:
    text = shown(table, "theta1,b", False, "ascii")
    assert text.isascii() and "theta1, b [m]" in text
    assert max(map(len, text.splitlines())) <= 80


@pytest.mark.parametrize("width", [20, 40, 200])
def test_any_width(table: Table, width: int) -> None:
    lines = shown(table, "theta1", False, width=width).splitlines()
    assert len(lines) > 10 and max(map(len, lines)) <= width


@pytest.mark.parametrize(
    "words",
    [
        (),
        ("--phase", "theta"),
        ("--spectrum", "theta"),
        ("--drift",),
        ("--at", "lowest"),
        ("--scene", "all_amplitudes"),
        ("--path", "x,y"),
    ],
)
def test_each_kind_of_picture(words: tuple) -> None:
    done = ran("plot", PENDULUM, *words)
    assert len(done.stdout.splitlines()) > 15 and "┤" in done.stdout


def test_images_and_space() -> None:
    done = run_pkgen("plot", ROOT / "models/chains/fput.lag", "--columns", "q")
    assert done.returncode == 0 and "@" in done.stdout and "q: " in done.stdout
    free = ROOT / "models/bodies/free_body.lag"
    done = run_pkgen("plot", free, "--path", "R.x,R.y,R.z")
    assert done.returncode == 0 and "seen from the side" in done.stdout


def test_nothing_of_matplotlib_is_imported(tmp_path: Path) -> None:
    command = [sys.executable, "-X", "importtime", "-m", "pkgen", "plot", PENDULUM]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0 and "pkgen.plot.terminal" in done.stderr
    assert "matplotlib" not in done.stderr and "sympy" not in done.stderr
