"""What is said of a wrong option, of a motion that is no chaos, of a line that is none."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from conftest import ROOT, case, written
from pkgen.__main__ import main
from pkgen.analysis.chart import text
from pkgen.analysis.chart.spectrum import Spectrum
from pkgen.front.parse import parse_all
from pkgen.run.diagnostics_text import lines
from pkgen.source import Source

# x runs away, y goes uniformly, z stays; `kept` is a constant of the motion, zero but for errors.
MODEL = case("three")


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = written(tmp_path, MODEL)
    return path


def test_a_run_says_what_its_numbers_are(model: Path, capsys) -> None:
    options = ["--scene", "section", "--diagnose", "lyapunov,spectrum", "--every", "0.1", "--json"]
    assert main(["run", str(model), *options]) == 0
    shown = capsys.readouterr()
    report = json.loads(shown.out)["report"]
    assert "event kept: its function stays within 1e-08 of zero" in shown.err
    assert "event half: its" not in shown.err and [e["count"] for e in report["events"]][1] == 1
    found = report["diagnostics"]
    assert found["lyapunov"]["motion"] == "leaving" and found["lyapunov"]["megno"] > 6
    said = "\n".join(lines(found, ""))
    assert "an instability and no chaos" in said
    assert "y: goes uniformly, by 1; it does not oscillate" in said and "z: constant, 2" in said
    # x grows like e^t: neither of the two.
    assert found["spectrum"]["coordinates"][0]["away"] > 0.1
    # Rows at the event alone are at no equal times, and this is said with what to do.
    assert main(["run", str(model), *options[:4], "--json"]) == 2
    assert "rows are at event half alone: give --every too" in capsys.readouterr().err


def test_no_field_of_c_is_in_a_reason() -> None:
    source = (ROOT / "runtime/src/reason.c").read_text(encoding="utf-8")
    words = " ".join(part for part in source.split('"')[1::2])
    assert "tolerance" in words
    for field in ("h_max", "h_min", "rtol", "atol", "newton_tol", "max_steps", "max_iterations"):
        assert field not in words


def test_a_scene_with_a_reserved_name_has_one_error() -> None:
    scene = "scene event\n  start x = 1\n  until 5\nend\nscene good\n  until 5\nend\nuntil 3\n"
    source = Source("m.lag", "model m\ncoord x\nkinetic x'^2/2\npotential x^2/2\n" + scene)
    found = parse_all(source).diagnostics
    assert [d.message.split("'")[1] for d in found] == ["event", "until"]
    assert found[1].span.start == source.text.rindex("until")


def test_a_motion_without_frequencies() -> None:
    assert Spectrum(0.0, 0.0, 10.0).text("s").startswith("nothing oscillates")
    assert Spectrum(2.0, 0.0, 10.0).text("s").startswith("fastest oscillation")
    assert text.EXACT > 2.0**-52
