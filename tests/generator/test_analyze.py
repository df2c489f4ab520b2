"""Structure about a system: each true where it can be proved, each false where it does not hold."""

from dataclasses import replace
from itertools import islice

import pytest
from building import links, model

from conftest import case
from pkgen.back.c.render import FACTS
from pkgen.compiler import stages
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.analyze.analyze import analyze
from pkgen.middle.derive.derive import derive
from pkgen.source import Source

# Potentials and forces below are not quadratic, or not steady, so that nothing is affine.
FREE = dict(params={"m": 1.3, "k": 2.1}, coords=("x", "y"), kinetic="m/2*(x'^2 + y'^2)")


def facts(**given):
    return analyze(derive(model(**given)))


def test_a_plain_system_has_every_fact():
    found = facts(**FREE, potential="k/2*x^2")
    assert found.mass_constant and found.mass_diagonal and found.quadratic
    assert found.separable and found.autonomous and found.conservative
    assert found.variational and found.smooth
    assert found.cyclic == (False, True)


# Each changes one thing about the plain system, and these facts go.
@pytest.mark.parametrize(
    ("change", "gone"),
    [
        (dict(potential="k*x*cos(3*t)"), {"autonomous", "conservative"}),
        (dict(potential="k*x*u", inputs=("u",)), {"autonomous", "conservative", "series"}),
        (dict(dissipation="k/2*x'^4"), {"separable", "conservative", "variational"}),
        (dict(forces={"x": "-k*x^3"}), {"conservative", "variational"}),
        (dict(forces={"x": "t"}), {"autonomous", "conservative", "variational"}),
        (dict(potential="k*abs(x)"), {"smooth"}),
        (dict(potential="k*max(x, 0)^3"), {"smooth"}),
        (dict(lagrangian="k*x'*y' + k*x^3"), {"mass_diagonal"}),
        (dict(lagrangian="x*y*x'*k"), {"separable"}),  # gyroscopic: M constant, f not free of v
        (dict(lagrangian="k*x'^4"), {"mass_constant", "quadratic", "separable"}),
        (dict(lagrangian="k*x^2*x'^2"), {"mass_constant", "separable"}),
    ],
)
def test_one_thing_changed(change, gone):
    found = facts(**(FREE | change))
    if "smooth" not in gone:
        gone = gone | {"switched"}  # said of what bends only
    lacking = {name for name in FACTS.split() if not getattr(found, name)}
    assert lacking - {"linear_drag", "affine_rates"} == gone | {"affine", "fast"}


# What stands in the forces beside the rates: nothing else, coefficients that vary, or more.
@pytest.mark.parametrize(
    ("change", "linear_drag", "affine_rates"),
    [
        ({}, False, False),  # separable, which is more
        (dict(dissipation="k/2*(x' - 2*y')^2", forces={"x": "cos(x*t)"}), True, True),
        (dict(lagrangian="k*x*y'", potential="x^4"), True, True),
        (dict(kinetic="m/2*((x' - k*y)^2 + (y' + k*x)^2)", potential="x^4"), True, True),
        (dict(lagrangian="k*x*y*x'"), False, True),
        (dict(lagrangian="k*x^2*y'", dissipation="k/2*x'^2"), False, True),
        (dict(forces={"x": "-u*x'"}, inputs=("u",)), False, True),
        (dict(forces={"x": "-t*y'"}), False, True),
        (dict(forces={"x": "step(x)*x'"}), False, True),
        (dict(forces={"x": "-k*abs(x')*x'"}), False, False),
        (dict(forces={"x": "-k*x'*y'"}), False, False),
        (dict(forces={"x": "-tanh(x')"}), False, False),
        (dict(lagrangian="k*x^2*x'^2", dissipation="x'^2"), False, False),
    ],
)
def test_how_forces_depend_on_the_rates(change, linear_drag, affine_rates):
    found = facts(**(FREE | change))
    assert (found.linear_drag, found.affine_rates) == (linear_drag, affine_rates)
    assert not (linear_drag and found.separable)


def test_cyclic_needs_no_force_along_it():
    assert facts(**FREE, potential="k*x^2").cyclic == (False, True)
    assert facts(**FREE, potential="k*x^2", forces={"y": "k"}).cyclic == (False, False)
    assert facts(**FREE, dissipation="y'^2").cyclic == (True, False)


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
        kinetic="m/2*(x'^2 + y'^2 + z'^2)",
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


@pytest.mark.parametrize(
    ("change", "affine"),
    [
        (dict(), True),
        (dict(potential="k/2*(x - 2*y)^2 + m*x"), True),
        (dict(lagrangian="k*x'*y' + k*x*y'", dissipation="k/2*x'^2"), True),
        (dict(potential="k/2*x^2*(sin(y)^2 + cos(y)^2)"), True),
        (dict(potential="k*x^3"), False),
        (dict(potential="k/2*x^2*(1 + cos(3*t))"), False),
        (dict(forces={"x": "u"}, inputs=("u",)), False),
        (dict(lagrangian="k*x^2*x'^2"), False),
        (dict(forces={"x": "abs(x')"}), False),
        (dict(forces={"x": "x*x'"}), False),
        (dict(lagrangian="t*x'"), False),  # nothing of it in f, but in the momentum
    ],
)
def test_affine(change, affine):
    assert facts(**(FREE | change)).affine is affine


def test_affine_by_identity():
    equations = derive(model(**FREE))
    g = equations.graph
    x = g.symbol(Symbol(Kind.COORDINATE, 0))
    square = g.multiply(x, g.add(x, g.number(3)))
    force = (g.subtract(square, g.power(x, 2)), equations.force[1])
    assert analyze(replace(equations, force=force)).affine
    assert not analyze(replace(equations, force=(square, equations.force[1]))).affine


def test_mass_blocks_and_band():
    """p and q share an inertia, and so do r and s; a third pair is one by identity only."""
    found = facts(
        coords=("p", "q", "r", "s"),
        kinetic="(p'^2 + q'^2 + r'^2 + s'^2)/2 + p'*r'/3",
        lagrangian="q'*s'*(sin(p)^2 + cos(p)^2 - 1)",
    )
    assert found.mass_blocks == ((0, 2), (1,), (3,)) and found.mass_band == 2
    assert not found.mass_diagonal


PAIR = dict(coords=("p", "q", "r"), kinetic="(p'^2 + q'^2 + r'^2)/2")


@pytest.mark.parametrize(
    ("change", "influences", "blocks"),
    [
        (dict(potential="cos(p) + cos(q)"), ((0,), (1,), ()), ((0,), (1,), (2,))),
        (dict(potential="cos(p - r)"), ((0, 2), (), (0, 2)), ((0, 2), (1,))),
        # A force goes one way; a block has both.
        (dict(forces={"p": "-q'"}), ((1,), (), ()), ((0, 1), (2,))),
        (dict(forces={"q": "-p'"}), ((), (0,), ()), ((0, 1), (2,))),
        # M depends on a rate, and no force does.
        (dict(lagrangian="p'^2*r'^2", potential="r"), ((0, 2), (), (0, 2)), ((0, 2), (1,))),
        (dict(lagrangian="p'*q'/2 + cos(q)"), ((1,), (1,), ()), ((0, 1), (2,))),
        # An inertia that two share, in which neither occurs.
        (dict(lagrangian="p'*q'/2"), ((), (), ()), ((0, 1), (2,))),
        # Through M, though not in any force.
        (dict(lagrangian="r^2*p'^2"), ((0, 2), (), (0, 2)), ((0, 2), (1,))),
        # q drops out by an identity.
        (dict(forces={"p": "r*(sin(q)^2 + cos(q)^2)"}), ((2,), (), ()), ((0, 2), (1,))),
    ],
)
@pytest.mark.parametrize("solved", [True, False])
def test_influences(change, influences, blocks, solved):
    equations = derive(model(**(PAIR | change)))
    if not solved:
        equations = replace(equations, acceleration=None)
    found = analyze(equations)
    assert all(set(a) <= set(b) for a, b in zip(influences, found.influences, strict=True))
    assert found.blocks == blocks
    if solved:
        assert found.influences == influences


def test_definite_is_proved_from_bounds():
    def with_bounds(lo):
        e = derive(model(**FREE))
        zero = e.graph.number(lo)
        slots = tuple(replace(slot, lo=zero, lo_open=True) for slot in e.parameters)
        return analyze(replace(e, parameters=slots))

    assert with_bounds(0).definite and not with_bounds(-1).definite


LINKS = case("analyze_links")
SECOND = "m/2*(x'^2 + y'^2)"


@pytest.mark.parametrize(
    ("kinetic", "definite"),
    [
        (f"{SECOND} + m/3*(u'^2 + v'^2)", True),
        (f"{SECOND} + m/3*((u + t^2)'^2 + (v - sin(t*b))'^2) - n*t", True),  # driven
        (f"{SECOND} + n/3*(u'^2 + v'^2)", False),  # massless
        (f"{SECOND} + m/3*(u'^2 - v'^2)", False),  # v.M v could be 0 anyhow
        (f"{SECOND} + m/3*u'^2", False),  # is 0 where cos(c) is
        (f"{SECOND} + m/3*(u'^2 + v'^2) - m*a'^2", False),
        ("(a'^2 + 1)*b'^2 + c'^2", False),  # of fourth degree
        ("m/3*(u'^2 + v'^2)", False),  # two at once, but folded
        ("m*((a' + b' + c')^2 + (b' - (2 + n)*c')^2)", True),  # two at once
        ("m*((a' + b' + c')^2 + (b' - n*c')^2)", True),
        ("m*((a' + b' + c')^2 + (b' + n*c')^2)", False),  # where n = 1
    ],
)
def test_definite_by_squares(kinetic, definite):
    """Three links, of whose pivots nothing is seen."""
    kernels = frozenset({"force", "lagrangian"})
    text = f"{LINKS}kinetic {kinetic}\n"
    *_, structure = islice(stages(Source("x.lag", text), {}, kernels), 4)
    assert structure.definite == definite


def test_where_the_mass_matrix_may_be_singular():
    found = facts(params={"m": 1}, coords=("r", "a"), kinetic="m/2*(r'^2 + r^2*a'^2)")
    assert found.singular == ("r",) and not found.definite


CHAIN = case("analyze_chain")


@pytest.mark.parametrize(
    ("old", "new", "affine"),
    [
        ("", "", True),
        ("/2*(q[i+1] - q[i])^2", "/4*(q[i+1] - q[i])^4", False),
        ("= 0.2,", "= sin(t),", False),
        ("q[i]'^2/i", "q[i]'^2*q[i]^2", False),
        ("k[i]/2", "k[i]/2*cos(q[1] - q[1] + i)", True),
        ("q[i]'^2/2", "q[i]'^2/2*(1 + q[i]^2)", False),
        ("q[i]'^2/2", "q[i]'^4/2", False),
        ("q[i]'^2/2", "q[i]'^2/2 + t*q[i]'", False),
        ("dissipation", "force q[i = 1..N] = q[i]*q[i]'\ndissipation", False),
    ],
)
def test_affine_of_loops(old, new, affine):
    (_, _, equations) = islice(stages(Source("chain.lag", CHAIN.replace(old, new)), {}), 3)
    assert equations.facts.affine is affine
