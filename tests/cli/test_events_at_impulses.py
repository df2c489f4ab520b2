"""An event at an impulse, or where the state is put back onto a constraint: crossed once."""

from __future__ import annotations

from itertools import pairwise

import pytest

from conftest import case, ran

METHODS = ["gauss", "dop853", "dopri5", "radau", "rk4", "gauss4", "gsl_rk8pd"]
BENT = case("bent")
STARTS = (
    "start x = 0.095 + 0.002*k, y = -0.381, x' = 0.227, y' = -0.42\n"
    "  start z = 0.5*F(0.3*0.381^2 - 0.095 - 0.002*k + 0.220) - 0.2*sin(0.381)\n"
    "  start z' = 0.5*D*(0.3*2*0.381*0.42 - 0.227) - 0.2*cos(0.381)*0.42\n"
)
# Where the rates jump; where they do not, but the state is put back onto the constraint.
IMPULSE = BENT.replace("START", STARTS.replace("F", "abs").replace("D", "1"))
KINK = (
    BENT.replace("abs(0.3*y^2 - x + 0.220)", "(0.3*y^2 - x + 0.220)")
    .replace("0.7*abs(0.3*y^2 - x - 0.326)", "0.7*step(0.3*y^2 - x + 0.220)")
    .replace("START", STARTS.replace("F", "").replace("D", "1"))
)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("text", [IMPULSE, KINK], ids=["impulse", "kink"])
def test_it_is_crossed_once(write, text: str, method: str) -> None:
    options = ("--scene=s", "--method", method, "--step=0.01", "--at=e")
    done = ran("run", write(text), *options)
    at = [tuple(map(float, row.split(",")[:2])) for row in done.stdout.splitlines()[1:]]
    twice = [b for a, b in pairwise(at) if a[0] == b[0] and b[1] - a[1] < 1e-6]
    assert len(at) >= 24 and not twice
