"""`pkgen run --diagnose`: what it finds, against closed forms and values known from elsewhere."""

from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from conftest import ROOT, case, diagnosed, ran, wait_for
from pkgen.run import runtime
from pkgen.system import toolchain

DOUBLE = ROOT / "models/double_pendulum.lag"
FPUT = ROOT / "models/chains/fput.lag"
SWING = """model swing
coord x
kinetic x'^2/2
potential -cos(x)
start x = 1.3
event bottom: x falling"""
RK4 = ("--method", "rk4", "--step", "0.01")
DAMPED = case("diagnose_damped")


def starts(angle: float) -> list[str]:
    found = ["--start", "theta1'=0", "--start", "theta2'=0"]
    return [*found, "--start", f"theta1={angle}", "--start", f"theta2={angle}"]


def test_a_chaotic_pendulum(tmp_path: Path) -> None:
    # REGIMES D2 and D3, by the midpoint rule, whose reversal is exact but for round-off.
    arguments = ["--method", "gauss1", "--step", "0.004", *starts(math.pi / 2)]
    what = ["lyapunov", "reversal", "spectrum", "symplectic"]
    arguments += ["--until", "100", "--every", "0.1"]
    found, *_ = diagnosed(tmp_path, DOUBLE, ",".join(what), *arguments)
    assert list(found) == what
    chaos, back = found["lyapunov"], found["reversal"]
    assert chaos["motion"] == "chaotic" and 0.01 < chaos["error"] < 0.3
    assert abs(chaos["exponent"] - 0.926) < 4 * chaos["error"]
    assert back["lost"] and back["symmetric"]
    expected = math.log(1e-3 / sys.float_info.epsilon) / chaos["exponent"]
    assert back["predicted"] == pytest.approx(expected, rel=1e-12)
    assert 0.7 * 31.4 < back["horizon_lo"] < back["horizon_hi"] < 1.5 * 31.4
    assert found["symplectic"]["symplectic"] and 0 < found["symplectic"]["defect"] < 1e-12
    assert found["symplectic"]["failed"] == 0 and found["symplectic"]["states"] == 16
    assert all(c["residual"] > 0.03 for c in found["spectrum"]["coordinates"])


def test_a_regular_pendulum(tmp_path: Path) -> None:
    # D3: a regular orbit returns; rk4 does not, nor does it keep the symplectic form.
    arguments = ["--until", "60", "--step", "0.01", *starts(0.5)]
    found, _, report = diagnosed(
        tmp_path, DOUBLE, "reversal,symplectic", *arguments, "--method", "gauss2"
    )
    worse, _, drifting = diagnosed(
        tmp_path, DOUBLE, "symplectic,reversal", *arguments, "--method", "rk4"
    )
    errors = [r["reversal"]["times"][-1][1] for r in (found, worse)]
    assert not found["reversal"]["lost"] and 0 < errors[0] < 1e-13 and errors[1] > 1e3 * errors[0]
    assert worse["symplectic"]["defect"] > 1e3 * worse["symplectic"]["rounding"]
    assert not worse["symplectic"]["symplectic"] and found["symplectic"]["symplectic"]
    assert [r["drifts"][0]["growth"] for r in (report, drifting)] == ["bounded", "secular, as t"]
    assert abs(drifting["drifts"][0]["exponent"] - 1) < 0.1


def test_frequencies_of_normal_modes(tmp_path: Path) -> None:
    # REGIMES D1: the double pendulum's small swings.
    swings = [*starts(1e-6), "--until", "300", "--every", "0.3"]
    method = ["--method", "gauss8", "--step", "0.1"]
    found, *_ = diagnosed(tmp_path, DOUBLE, "spectrum,symplectic", *swings, *method)
    slow, fast = found["spectrum"]["coordinates"][0]["lines"][:2]
    assert abs(slow["frequency"] - 2.3971993979) < 1e-10
    assert abs(fast["frequency"] - 5.7873512980) < 1e-10
    assert 0 < max(slow["error"], fast["error"]) < 1e-9


def test_forces_shrink_the_form(tmp_path: Path) -> None:
    # d/dt of an area in (q, p) under p' = ... - c v: exp(-c h) in all, whatever the method.
    found, *_ = diagnosed(tmp_path, DAMPED, "symplectic", "--step", "0.1", "--method", "gauss4")
    result = found["symplectic"]
    assert not result["variational"] and not result["symplectic"]
    assert result["volume"] == pytest.approx(math.exp(-0.02) - 1, abs=1e-12)


def test_forces_that_keep_the_form(tmp_path: Path) -> None:
    """A force of an input alone moves all alike; that there are forces is said, and no more."""
    text = "model m\ncoord x\ninput f\nkinetic x'^2/2\npotential x^2/2\nforce x = f\n"
    words = ["--start", "x=1", "--step", "0.1", "--method", "gauss4"]
    found, *_ = diagnosed(tmp_path, text, "symplectic", *words)
    assert found["symplectic"]["symplectic"] and not found["symplectic"]["variational"]


def test_a_chain_is_unrolled_for_its_derivatives(tmp_path: Path) -> None:
    arguments = ["--until", "300", "--size", "N=17", "--method", "verlet", "--step", "0.1"]
    found, *_ = diagnosed(tmp_path, FPUT, "lyapunov", *arguments)
    assert found["lyapunov"]["motion"] == "regular" and found["lyapunov"]["exponent"] < 0.02


def test_what_is_said() -> None:
    arguments = ["--until", "60", "--method", "rk4", "--step", "0.05"]
    done = ran("run", DOUBLE, "--diagnose", "all", *starts(2), *arguments, "-v")
    lines = [line for line in done.stderr.splitlines() if not line.startswith("pkgen: ")]
    kinds = [line.partition(":")[0] for line in lines]
    assert "run: warning: the energy" in done.stderr  # off by .1
    assert "run: diagnose action: 2 coordinates" in done.stderr
    assert "run: diagnose lrl: at the start the two do not attract" in done.stderr
    said = [kind for kind in kinds if kind != "run"][2:]
    of_bobs = [f"angular momentum about the {place}" for place in ("origin", "centre of mass")]
    of_bobs = [of_bobs[0]] * 2 + [of_bobs[1]] * 2
    of_bobs = ["angular momentum of the particles at (x1, y1), (x2, y2)", *of_bobs]
    of_any = ["lyapunov", "reversal", "spectrum", "spectrum", "symplectic", "least_action"]
    assert said == [*of_any, *of_bobs, "modes", "modes", "modes"]
    assert "chaotic, exponent 1." in done.stderr and "/s (megno" in done.stderr
    assert "not symmetric" in done.stderr and "rad/s" in done.stderr
    assert "round-off alone would lose it near" in done.stderr
    (drift,) = [line for line in done.stderr.splitlines() if line.startswith("drift(energy)")]
    assert "relative to" in drift and "(t^" in drift


def test_the_example_in_c(pkgen, tmp_path: Path) -> None:
    text = (ROOT / "docs/lyapunov.c").read_text()
    assert text in (ROOT / "docs/diagnostics.md").read_text()
    assert pkgen(DOUBLE, "--runtime", "-o", tmp_path).returncode == 0
    tools = toolchain.find_toolchain()
    library = runtime.runtime_library(tools)
    flags = ["-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    include = [f"-I{tmp_path}", f"-I{ROOT / 'runtime/include'}", "-DPK_RUNTIME"]
    sources = [ROOT / "docs/lyapunov.c", tmp_path / "double_pendulum.c", library / "librun.a"]
    links = runtime.runtime_links(tools, library)
    subprocess.run(
        ["gcc", *flags, *include, *sources, *links, "-o", tmp_path / "program"], check=True
    )
    done = subprocess.run([tmp_path / "program"], capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)["diagnostics"]["lyapunov"]
    assert 0.01 < found["error"] < 0.1 and abs(found["exponent"] - 1.343) < 4 * found["error"]
    assert found["motion"] == "chaotic"


def test_an_interrupt_ends_it_with_the_rows_written(tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    command = [sys.executable, "-m", "pkgen", "run", str(DOUBLE), "--method", "gauss8"]
    command += ["--step", "0.001", "--until", "300", "--every", "150", "--diagnose", "lyapunov"]
    child = subprocess.Popen([*command, "-o", str(out)], stderr=subprocess.PIPE, text=True)
    partial = out.with_name("rows.csv.partial")
    wait_for(lambda: partial.exists() and partial.read_text().count("\n") == 4, child)
    time.sleep(0.3)
    child.send_signal(signal.SIGINT)
    assert child.wait(timeout=300) == 130
    assert child.stderr.read().startswith("run: interrupted in --diagnose\n")
    assert out.read_text().splitlines()[-1].startswith("300,")
    report = json.loads(out.with_name("rows.csv.json").read_text())["report"]
    assert report["whole"] and "diagnostics" not in report


def test_a_run_that_an_event_ends(tmp_path: Path) -> None:
    # Diagnosed as far as it went.
    found, _, report = diagnosed(
        tmp_path, SWING + " stop\n", "reversal,symplectic", "--until", "100", *RK4
    )
    assert report["status"] == "PK_STOPPED_EVENT" and 1 < report["t"] < 3
    assert found["reversal"]["times"][-1][0] <= report["t"]
    assert found["symplectic"]["t"] <= report["t"] and found["symplectic"]["states"] == 16


def test_least_action_is_a_minimum_up_to_the_first_conjugate_point(tmp_path: Path) -> None:
    hoop = ROOT / "models/bead_on_hoop.lag"
    found, text, _ = diagnosed(tmp_path, hoop, "least_action", "--until", 1)
    found = found["least_action"]
    assert found["minimum"] and found["index"] == 0 and found["conjugate"] == []
    assert "a minimum among paths with the same ends" in text
    found, text, _ = diagnosed(tmp_path, hoop, "least_action", "--until", 3)
    found = found["least_action"]
    assert not found["minimum"] and found["settled"]
    assert found["index"] == len(found["conjugate"]) == 2
    assert found["conjugate"][0] == pytest.approx(1.18315949, abs=1e-6)
    assert found["slope"] < 1e-12 < abs(found["neighbour"])
    assert found["neighbour"] == pytest.approx(found["expected"], rel=1e-3)
    assert found["curvatures"][0] < found["curvatures"][1] < 0 < found["curvatures"][2]
    assert "no minimum: 2 independent ways to a neighbour with less; conjugate" in text


def test_least_action_takes_as_many_modes_as_its_conjugate_points_ask(pkgen, tmp_path) -> None:
    """Of an eccentric orbit 24 modes show no way down yet, and there are eight."""
    rows = tmp_path / "rows.csv"
    words = ["--until", "30", "--method", "gauss", "--rtol", "1e-13", "-o", rows]
    model = ROOT / "models/particles/kepler.lag"
    done = pkgen("run", model, *words, "--diagnose", "least_action,modes")
    assert done.returncode == 0 and "modes: 1.953125" in done.stderr  # of the circular orbit
    found = json.loads(Path(f"{rows}.json").read_text())["report"]["diagnostics"]["least_action"]
    assert not found["minimum"] and found["index"] == len(found["conjugate"]) == 8
    assert found["modes"] > 24
