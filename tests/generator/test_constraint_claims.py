"""`conserve` where there are constraints, rolling and rotations: proved, refuted, or neither."""

import pytest
from test_constraints import facts

from conftest import case
from pkgen.compiler import compile_model
from pkgen.source import ModelError, Source

SPHERE = case("sphere")
BALL = case("constraint_claims_ball")


# A belt that moves takes work from what is on it: x' = 1 + y', lambda = -1/2, and L + t/2 does not.
BELT = case("belt")
# Its potential is of the attitude, which is no explicit time.
TOP = case("constraint_claims_top")


def test_claims_that_hold_on_the_constraints_alone():
    for text, count in ((SPHERE, 3), (BALL, 6), (BELT, 1), (TOP, 1)):
        found = facts(text).claims
        assert [claim.outcome for claim in found] == ["proved"] * count


BEAD = case("constraint_claims_bead")


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
