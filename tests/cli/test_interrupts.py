"""What is interrupted keeps and draws what it has, and says so."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

from pkgen.__main__ import main
from pkgen.analysis.chart import long
from pkgen.analysis.chart.sweep import Bench
from pkgen.analysis.stability import measure
from pkgen.system import children

MODEL = "model p\ncoord a\nkinetic a'^2/2\npotential -cos(a)\nstart a = 1\n"
CHART = ("chart", "p.lag", "--until", "5", "--methods", "rk4,verlet,dop853", "--seconds", "60")


@pytest.fixture(autouse=True)
def begun_anew(tmp_path, monkeypatch) -> Iterator[None]:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.lag").write_text(MODEL)
    yield
    with children.ended_by_signals():  # runs may go on
        pass


def interrupting(real: Callable, calls: int, name: str, times: int = 1) -> Callable:
    """The same, but that it is interrupted at so many calls."""
    made = [0]

    def call(*given: object, **more: object) -> object:
        made[0] += 1
        if calls <= made[0] < calls + times:
            os.kill(os.getpid(), getattr(signal, f"SIG{name}"))
        return real(*given, **more)

    return call


# In the first method, in the last, among the answers.
@pytest.mark.parametrize(
    "calls, name", [pytest.param(4, "INT", marks=pytest.mark.long), (30, "TERM"), (60, "INT")]
)
def test_a_chart_that_is_interrupted_is_drawn(calls, name, monkeypatch, capsys, tmp_path) -> None:
    monkeypatch.setattr(Bench, "point", interrupting(Bench.point, calls, name))
    assert main([*CHART, "--json"]) == 130
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert found["interrupted"] and "interrupted: the answers are of what was measured" in err
    with open(tmp_path / "p_chart.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) <= calls - 1 and {row["method"] for row in rows}.isdisjoint(
        found["unmeasured"]
    )
    assert calls > 4 or "dop853" in found["unmeasured"]
    assert "Interrupted" in (tmp_path / "p_chart.svg").read_text()
    assert any(a["method"] for a in found["answers"]) or calls == 4


def test_a_chart_interrupted_before_anything_is_measured_leaves_nothing(
    monkeypatch, capsys, tmp_path
) -> None:
    monkeypatch.setattr(Bench, "point", interrupting(Bench.point, 1, "INT"))
    assert main([*CHART]) == 130
    assert not list(tmp_path.glob("p_chart*"))
    assert "Traceback" not in capsys.readouterr().err


MAP = ("stability", "p.lag", "--until", "9", "--points", "6x8", "--methods", "rk4,gauss1")


# Among the rows, the last of them, among what is measured of predictions.
@pytest.mark.parametrize("what, calls", [("row", 4), ("row", 8), ("measured", 2)])
def test_a_map_that_is_interrupted_is_drawn(what, calls, monkeypatch, capsys, tmp_path) -> None:
    real = getattr(measure, what)
    monkeypatch.setattr(measure, what, interrupting(real, calls, "INT"))
    assert main([*MAP, "--json"]) == 130
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert found["interrupted"] and "interrupted: " in err
    values = [row["x"] for row in found["rows"]]
    assert 2 <= len(values) <= 8 and values == sorted(values) == found["varied"]["values"]
    assert what == "measured" or len(values) < 8
    assert values[-1] > 2 * values[0]  # all over the map, coarsely
    with open(tmp_path / "p_stability.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert (
        len(rows) == 12 * len(values)
        and "Interrupted" in (tmp_path / "p_stability.svg").read_text()
    )
    # No point is one that was ended by the interrupt.
    assert not any(row["status"] == "PK_STOPPED_USER" for row in rows)


def test_a_map_interrupted_at_once_leaves_nothing(monkeypatch, capsys, tmp_path) -> None:
    monkeypatch.setattr(measure, "row", interrupting(measure.row, 1, "TERM"))
    assert main([*MAP]) == 130
    assert not list(tmp_path.glob("p_stability*"))


def test_a_chart_of_drifts_has_the_methods_measured_until_then(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(long, "_decades", interrupting(long._decades, 2, "INT"))
    assert main([*CHART, "--long", "--step", "0.1"]) == 130
    assert "interrupted" in capsys.readouterr().err
    text = (tmp_path / "p_long.csv").read_text()
    assert "rk4" in text and "verlet" not in text


def test_what_a_chart_took_is_said(capsys) -> None:
    asked = [*CHART[:-1], "2", "--points", "4"]
    assert main(asked) == 0
    out = capsys.readouterr().out
    assert " s of the processor's" in out and "interrupted" not in out


SWARM = "until = 100\nmembers = 800\nstep = 0.01\nmethod = 'rk4'\n[random]\na = '-3 .. 3 [rad]'\n"
MOMENTS = [0.0, 0.003, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2]  # s after the first members begin
# A sweep that is told three times to end, first so many seconds after its first run begins.
ENDED = """\
import os, signal, sys, threading
from pkgen.__main__ import main
from pkgen.run import library
real, going = library.Library.run, []
def run(*given, **more):
    if not going:
        for k in range(3):
            after = float(sys.argv[1]) * (1 + k / 10)
            going.append(threading.Timer(after, os.kill, (os.getpid(), signal.SIGTERM)))
            going[-1].start()
    return real(*given, **more)
library.Library.run = run
signal.signal(signal.SIGTERM, lambda *_: None)  # one may come when all is over
code = main(["sweep", "p.lag", "--plan", "plan.toml", "-o", "made", "--workers", "1"])
for kill in going:
    if kill.is_alive():  # the one of which the signal came before it was seen to start is not
        kill.join()
sys.exit(code)
"""


@pytest.mark.needs_addon("sweep")
@pytest.mark.parametrize("after", MOMENTS)
def test_a_sweep_that_is_ended_while_it_times_its_first_members(after, tmp_path) -> None:
    """The run is over before its memory is given back, however often it is told to end."""
    (tmp_path / "plan.toml").write_text(SWARM)
    command = [sys.executable, "-c", ENDED, str(after)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    said = done.stderr
    assert done.returncode == 130 and "internal" not in said and "Traceback" not in said, said
