"""Lyapunov exponents of the double pendulum to three digits, and where reversal loses it: REGIMES
D2 and D3 by `pkgen run --diagnose`. From (3, 3) D2 is too small: RK4 at h = 0.001 of equations
written by hand, two motions 1e-8 apart and drawn together again each second, has 1.0265 and 1.0262
over 1e5 s from starts 1e-5 apart."""

import json
import math

import pytest

from conftest import ROOT, ran

pytestmark = pytest.mark.long

DOUBLE = ROOT / "models/double_pendulum.lag"


def diagnosed(pkgen, angle: float, what: str, *arguments: object) -> dict:
    start = ["--start", f"theta1={angle}", "--start", f"theta2={angle}"]
    still = ["--start", "theta1'=0", "--start", "theta2'=0"]
    done = ran("run", DOUBLE, "--diagnose", what, "--json", *start, *still, *arguments)
    return json.loads(done.stdout)["report"]["diagnostics"]


@pytest.mark.parametrize(
    "angle, exponent, within", [(math.pi / 2, 0.926, 0.006), (2, 1.343, 0.005), (3, 1.0264, 0.002)]
)
def test_exponents(pkgen, angle: float, exponent: float, within: float) -> None:
    found = diagnosed(pkgen, angle, "lyapunov", "--until", "1e5", "--every", "1e3")["lyapunov"]
    assert found["motion"] == "chaotic" and 0.001 < found["error"] < 0.006
    assert abs(found["exponent"] - exponent) < 3 * math.hypot(within, found["error"])


def test_a_regular_motion(pkgen) -> None:
    found = diagnosed(pkgen, 0.5, "lyapunov", "--until", "1e5", "--every", "1e3")["lyapunov"]
    assert found["motion"] == "regular" and abs(found["megno"] - 2) < 0.1
    assert 0 < abs(found["exponent"]) < 1e-3


def test_reversal(pkgen) -> None:
    midpoint = ["--method", "gauss1", "--step", "0.001", "--until", "60"]
    lost = diagnosed(pkgen, math.pi / 2, "reversal", *midpoint)["reversal"]
    kept = diagnosed(pkgen, 0.5, "reversal", *midpoint)["reversal"]
    assert lost["lost"] and 31 < lost["horizon_lo"] < 45 and lost["horizon_hi"] < 50
    assert not kept["lost"] and 0 < kept["times"][-1][1] < 1e-13
