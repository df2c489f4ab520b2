"""`conserve` where there are constraints, rolling and rotations: proved, refuted, or neither."""

from __future__ import annotations

import pytest
from test_constraints import facts

from pkgen.compiler import compile_model
from pkgen.source import ModelError, Source

SPHERE = """\
model sphere
param m = 1.3 in (0, inf)
coord x, y, z
kinetic m/2*(x'^2 + y'^2 + z'^2)
potential 2.385*m*z
constraint rod: x^2 + y^2 + z^2 = 1
start x = 0.6, z = -0.8, y' = 1
conserve Lz = m*(x*y' - y*x')
conserve h = energy
conserve H = m/2*(x'^2 + y'^2 + z'^2) + 2.385*m*z
"""
BALL = """\
model ball
param I = 0.7 in (0, inf)
param a = 1.5 in (0, inf)
coord x, y, z
rotation R
let w = omega(R)
let W = R*w
kinetic (x'^2 + y'^2 + z'^2)/2 + I/2*dot(w, w)
potential z
rolling touch: [x', y', z'] = cross(W, [0, 0, a])
start omega(R) = [0, 1, 0], x' = a
conserve h = energy
conserve spin = W.z
conserve straight = [x', y', z']
conserve slip = W.x*a + y'
"""


# A belt that moves takes work from what is on it: x' = 1 + y', lambda = -1/2, and L + t/2 does not.
BELT = """\
model belt
coord x, y
kinetic (x'^2 + y'^2)/2
potential y
rolling belt: x' = 1 + y'
start x' = 1
conserve c = energy + t/2
"""
# Its potential is of the attitude, which is no explicit time.
TOP = """\
model top
param l = 0.3
rotation R
let w = omega(R)
kinetic w.x^2 + w.y^2 + w.z^2/2
potential l*(R*[0, 0, 1]).z
start omega(R) = [0, 1, 2]
conserve h = 3*energy
"""


def test_claims_that_hold_on_the_constraints_alone():
    for text, count in ((SPHERE, 3), (BALL, 6), (BELT, 1), (TOP, 1)):
        found = facts(text).claims
        assert [claim.outcome for claim in found] == ["proved"] * count


BEAD = """\
model bead
coord x, y
kinetic (x'^2 + y'^2)/2
constraint line: y*cos(2*t) = x*sin(2*t)
start x = 1, y' = 2
"""


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (BALL + "conserve wrong = W.x + x'\npotential x\n", "'straight.x' is not constant"),
        (BALL + "conserve turn = w.x*R.w\n", "'turn' is not constant: dturn/dt ="),
        (
            SPHERE + "conserve wrong = x'\n",
            "'wrong' is not constant: dwrong/dt = -1.745, where its terms are",
        ),
        (SPHERE.replace("= 1\n", "= 1 + t^2\n", 1), "that 'h' is constant is not proved"),
        # A rate that the row gives by the others, divided by what is 0 at the start.
        (BEAD + "conserve c = x'*cos(2*t) + y'*sin(2*t) - 2*x\n", "dc/dt = 4, where"),
        (BEAD + "conserve c = x'^3 + (y - 2*t)^2\n", "not looked for; dc/dt = 0, where"),
        (BELT.replace("t/2", "t/4"), "'c' is not constant: dc/dt = -0.25"),
        # A little beside terms that cancel.
        (
            SPHERE + "conserve wrong = x' + 1e3*(x*x' + y*y' + z*z')\n",
            "'wrong' is not constant: dwrong/dt = -1.745",
        ),
    ],
)
def test_claims_that_do_not(text, said):
    with pytest.raises(ModelError) as caught:
        compile_model(Source("model.lag", text))
    assert said in caught.value.text()
