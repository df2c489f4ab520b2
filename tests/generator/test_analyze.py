"""Facts about a system: each true where it can be proved, each false where it does not hold."""

from __future__ import annotations

import pytest
from building import links, model
from pkgen.middle.analyze import analyze
from pkgen.middle.derive import derive

FREE = dict(params={"m": 1.3, "k": 2.1}, coords=("x", "y"), kinetic="m/2*(D(x)**2 + D(y)**2)")


def facts(**given):
    return analyze(derive(model(**given)))


def test_a_plain_system_has_every_fact():
    found = facts(**FREE, potential="k/2*x**2")
    assert found.mass_constant and found.mass_diagonal and found.quadratic
    assert found.separable and found.autonomous and found.conservative
    assert found.variational and found.smooth
    assert found.cyclic == (False, True)


# Each changes one thing about the plain system, and these facts go.
@pytest.mark.parametrize(
    ("change", "gone"),
    [
        (dict(potential="k*x*cos(3*t)"), {"autonomous", "conservative"}),
        (dict(potential="k*x*u", inputs={"u": 0}), {"autonomous", "conservative"}),
        (dict(dissipation="k/2*D(x)**2"), {"separable", "conservative", "variational"}),
        (dict(forces={"x": "-k*x"}), {"conservative", "variational"}),
        (dict(forces={"x": "t"}), {"autonomous", "conservative", "variational"}),
        (dict(potential="k*abs(x)"), {"smooth"}),
        (dict(potential="k*max(x, 0)**3"), {"smooth"}),
        (dict(lagrangian="k*D(x)*D(y)"), {"mass_diagonal"}),
        (dict(lagrangian="x*y*D(x)*k"), {"separable"}),  # gyroscopic: M constant, f not free of v
        (dict(lagrangian="k*D(x)**4"), {"mass_constant", "quadratic", "separable"}),
        (dict(lagrangian="k*x**2*D(x)**2"), {"mass_constant", "separable"}),
    ],
)
def test_one_thing_changed(change, gone):
    found = facts(**(FREE | change))
    names = [f for f in found.__dataclass_fields__ if f != "cyclic"]
    assert {name for name in names if not getattr(found, name)} == gone


def test_cyclic_needs_no_force_along_it():
    assert facts(**FREE, potential="k*x**2").cyclic == (False, True)
    assert facts(**FREE, potential="k*x**2", forces={"y": "k"}).cyclic == (False, False)
    assert facts(**FREE, dissipation="D(y)**2").cyclic == (True, False)


@pytest.mark.parametrize(
    ("jump", "cyclic"),
    [("step(y)*x", (False, False)), ("step(y)", (True, False)), ("step(t)*x", (False, True))],
)
def test_where_the_lagrangian_jumps_nothing_is_constant(jump, cyclic):
    """A step has derivative 0: the force that does its work is not there."""
    found = facts(**FREE, potential=jump)
    assert not found.conservative
    assert found.cyclic == cyclic


def test_by_identity():
    """t and phi drop out of a Cartesian L; theta does not."""
    found = facts(
        params={"m": 1.3, "R": 0.7, "w": 2.1},
        coords=("theta", "phi"),
        lets={
            "x": "R*sin(theta)*cos(phi + w*t)",
            "y": "R*sin(theta)*sin(phi + w*t)",
            "z": "R*cos(theta)",
        },
        kinetic="m/2*(D(x)**2 + D(y)**2 + D(z)**2)",
        potential="m*z",
    )
    assert found.autonomous and found.conservative and found.mass_diagonal
    assert found.cyclic == (False, True)


def test_not_proved_is_false():
    """cos(x+y) is not taken apart, so that this t only seems to matter: false is allowed."""
    found = facts(**FREE, potential="cos(x + t) - cos(x)*cos(t) + sin(x)*sin(t)")
    assert not found.autonomous


def test_a_rotating_pair_is_not_smoothly_confused():
    assert analyze(derive(links(4))).smooth
