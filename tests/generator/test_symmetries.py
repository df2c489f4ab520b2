"""Noether's constants, found without being told; and none where there is none."""

from fractions import Fraction
from itertools import islice

import pytest
import sympy

from pkgen.compiler import stages
from pkgen.graph.exact import Exact
from pkgen.graph.nullspace import null_space
from pkgen.middle.analyze.along import Along
from pkgen.middle.analyze.proofs import vanishes
from pkgen.source import Source

PLANE = "coord x, y\nkinetic (x'^2 + y'^2)/2\n"
SPACE = "coord x, y, z\nparam m = 1.3\nkinetic m/2*(x'^2 + y'^2 + z'^2)\n"
CYLINDER = "coord r, phi, z\nparam m = 1.3\nkinetic m/2*(r'^2 + r^2*phi'^2 + z'^2)\n"
CENTRAL = "param mu = 2\npotential -mu/sqrt(x^2 + y^2)\n"
ANGULAR = ["x*p_y - y*p_x", "x*p_z - z*p_x", "y*p_z - z*p_y"]
SPHERE = """\
coord theta, phi
param l = 1.3
let x = l*sin(theta)*cos(phi)
let y = l*sin(theta)*sin(phi)
let z = -l*cos(theta)
kinetic (x'^2 + y'^2 + z'^2)/2
potential 9.81*z
"""
TOP = """\
coord phi, theta, psi
param A = 1
param C = 0.5
kinetic A/2*(theta'^2 + phi'^2*sin(theta)^2) + C/2*(psi' + phi'*cos(theta))^2
potential 9.81*cos(theta)
"""
HELIX = "param k = 0.7\npotential r^2 + r*cos(phi - k*z)\n"
LINKS = """\
coord a, b, c
let x = sin(a) + sin(b)
let y = cos(a) + cos(b)
kinetic (a'^2 + x'^2 + y'^2 + (x + sin(c))'^2 + (y + cos(c))'^2)/2
"""
CHAIN = """\
size N = 5
param m[i = 1..N] = i
coord q[1..N]
free q
kinetic sum(m[i]*q[i]'^2/2, i = 1..N)
potential sum((q[i+1] - q[i])^2/2 + (q[i+1] - q[i])^4/4, i = 0..N)
"""
TWO_BODIES = """\
param m = 2
coord x, y, u, v
kinetic m/2*(x'^2 + y'^2) + (u'^2 + v'^2)/2
potential -1/sqrt((x - u)^2 + (y - v)^2)
"""


def found(text):
    kernels = frozenset({"acceleration", "momenta"})
    made = stages(Source("x.lag", f"model test\n{text}"), {}, kernels, symmetric=True)
    *_, equations, structure = islice(made, 4)
    proved(equations, structure)
    return [x.name for x in structure.symmetries.invariants]


def proved(equations, structure):
    """Each once more, along the equations of motion with the accelerations in them."""
    along = Along(equations, structure.mass_blocks)
    along.graph = structure.symmetries.graph
    for x in structure.symmetries.invariants:
        assert vanishes(along.graph, Exact(along.graph), along.terms(x.node)), x.name


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (PLANE + CENTRAL, ["energy", "x*p_y - y*p_x"]),
        (SPACE + "potential -1/norm([x, y, z])\n", ["energy", *ANGULAR]),
        (
            PLANE + "param k = 2\npotential k/2*(x^2 + y^2)\n",
            ["energy", "energy(x)", "energy(y)", "x*p_y - y*p_x"],
        ),
        (SPHERE, ["energy", "p_phi"]),
        (TOP, ["energy", "p_phi", "p_psi"]),
        (CYLINDER + HELIX, ["energy", "k*p_phi + p_z"]),
        (
            SPACE + "param k = 0.7\npotential (x^2 + y^2)^2 + x*cos(k*z) + y*sin(k*z)\n",
            ["energy", "p_z + k*x*p_y - k*y*p_x"],
        ),
        # A helix that turns: neither energy nor momenta, but two combinations of the three.
        (
            CYLINDER + "param k = 0.7\nparam w = 2\npotential r*cos(phi - k*z - w*t)\n",
            ["k*p_phi + p_z", "energy - w*p_phi"],
        ),
        (LINKS, ["energy", "p_a + p_b + p_c"]),
        (
            CHAIN,
            [
                "energy",
                "p_q[1] + p_q[2] + p_q[3] + p_q[4] + p_q[5]",
                # of the centre of mass
                "t*p_q[1] + t*p_q[2] + t*p_q[3] + t*p_q[4] + t*p_q[5]"
                " - m[1]*q[1] - m[2]*q[2] - m[3]*q[3] - m[4]*q[4] - m[5]*q[5]",
            ],
        ),
        (
            SPACE + "potential x^4\n",
            # That of y alone is p_y^2/2.
            ["energy", "energy(x)", "p_y", "p_z", "t*p_y - m*y", "t*p_z - m*z", "y*p_z - z*p_y"],
        ),
        (  # a throw: the boost needs a gauge term that is quadratic in t
            "coord z\nparam m = 2\nparam g = 9.81\nkinetic m/2*z'^2\npotential m*g*z\n",
            ["energy", "p_z + m*g*t", "2*t*p_z - 2*m*z + m*g*t^2"],
        ),
        # scaling
        (
            PLANE + "potential 3/(x^2 + y^2)\n",
            ["energy", "x*p_y - y*p_x", "x*p_x + y*p_y - 2*t*energy"],
        ),
        # a magnetic field that L says by x y', and that a force says
        (
            PLANE + "param B = 3\nlagrangian B*x*y'\npotential x^2 + y^2\n",
            ["energy", "2*x*p_y - 2*y*p_x - B*x^2 + B*y^2"],
        ),
        (
            PLANE + "param B = 3\nforce x = B*y'\nforce y = -B*x'\npotential x^4 + y\n",
            ["energy", "p_y + B*x + t"],
        ),
    ],
)
def test_found(text, names):
    assert found(text) == names


def test_a_state_beside_many_coordinates_is_in_no_symmetry():
    text = "coord x[1..12]\nkinetic sum(x[i]'^2/2, i = 1..12)\n"
    text += "potential sum((x[i+1] - x[i])^2/2, i = 1..11)\nobserve w = integral(x[12]*x[11]')\n"
    assert "energy" in found(text)


def test_two_bodies_have_ten_of_which_some_are_of_the_centre_of_mass():
    names = found(TWO_BODIES)
    for name in ("energy", "p_x + p_u", "p_y + p_v", "x*p_y - y*p_x + u*p_v - v*p_u"):
        assert name in names
    assert "t*p_x + t*p_u - m*x - u" in names and len(names) == 7


def test_three_bodies_whose_common_denominator_is_too_large():
    """Then terms that are equal as they stand must do, and do."""
    text = "coord x, y, u, v, p, q\nparam m = 2\nparam k = 3\n"
    text += "kinetic (m*x'^2 + m*y'^2 + u'^2 + v'^2 + p'^2 + q'^2)/2\n"
    for a, b in (("x - u", "y - v"), ("x - p", "y - q"), ("u - p", "v - q")):
        text += f"potential -1/(m + k)/k/sqrt(({a})^2 + ({b})^2) + 1/(({a})^2 + ({b})^2)^3\n"
    *_, equations = islice(stages(Source("x.lag", f"model test\n{text}"), {}), 3)
    along = Along(equations, tuple((i,) for i in range(6)))
    assert Exact(along.graph, 40_000).numerators(equations.pdot) is None
    names = found(text)
    for name in ("p_x + p_u + p_p", "x*p_y - y*p_x + u*p_v - v*p_u + p*p_q - q*p_p"):
        assert name in names
    assert len(names) == 7


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (PLANE + CENTRAL + "potential 0.001*x\n", ["energy"]),
        (PLANE + CENTRAL.replace("y^2", "1.001*y^2"), ["energy"]),
        (PLANE + CENTRAL.replace("-mu", "-mu*(1 + t)"), ["x*p_y - y*p_x"]),
        (PLANE + CENTRAL.replace("-mu", "-mu*x*sin(t)"), []),
        (PLANE + CENTRAL + "dissipation x'^2/9\n", []),
        # What each block has by itself, the others driven or damped.
        (PLANE + "potential x^4 + t*y^4 + sin(t)\n", ["energy(x)"]),
        (SPACE + "potential x^4 + y^4 - y*z\ndissipation x'^2/9\n", ["energy(y, z)"]),
        (PLANE + "potential x^4 + y^4\nforce x = -y'\nforce y = x'\n", ["energy"]),
        (
            PLANE + "potential x^4\nlagrangian x*y' + y*x'\n",
            ["energy", "p_y - x", "t*p_y - y - t*x"],
        ),
        (PLANE + CENTRAL + "force x = y\n", []),
        (PLANE + CENTRAL + "force x = -y\nforce y = x\n", []),  # it turns
        (PLANE + CENTRAL + "input u\npotential u*y\n", []),
        (SPHERE + "dissipation phi'^2/9\n", ["9*p_phi + 2*phi"]),  # drag takes what phi makes
        (SPHERE + "dissipation x'^2/9\n", []),
        (SPHERE + "dissipation theta'^2/9\n", ["p_phi"]),
        (CYLINDER + HELIX + "potential 0.01*cos(phi)\n", ["energy"]),
        (LINKS + "potential y/9\n", ["energy"]),
        (CHAIN + "potential q[1]^4\n", ["energy"]),
        (
            CHAIN + "dissipation q[1]'^2/7\n",
            ["7*p_q[1] + 7*p_q[2] + 7*p_q[3] + 7*p_q[4] + 7*p_q[5] + 2*q[1]"],
        ),
        # Drag between two that are free together.
        (
            PLANE + "potential (x - y)^4\ndissipation (x' - y')^2/2\n",
            ["p_x + p_y", "t*p_x + t*p_y - x - y"],
        ),
    ],
)
def test_only_what_survives(text, names):
    assert found(text) == names


def test_where_the_lagrangian_jumps_nothing_is_searched():
    made = stages(Source("x.lag", f"model test\n{PLANE}potential step(x)\n"), {}, symmetric=True)
    *_, structure = islice(made, 4)
    assert structure.symmetries is None


def test_generators_and_reasons():
    made = stages(Source("x.lag", f"model test\n{CYLINDER}{HELIX}"), {}, symmetric=True)
    *_, structure = islice(made, 4)
    assert [(x.reason, x.generator) for x in structure.symmetries.invariants] == [
        ("time shift", "d/dt"),
        ("symmetry", "k d/dphi + d/dz"),
    ]
    assert structure.symmetries.searched.startswith("all point symmetries")


def test_large_models_say_what_was_searched():
    text = CHAIN.replace("N = 5", "N = 12")
    made = stages(Source("x.lag", f"model test\n{text}"), {}, unroll=None, symmetric=True)
    *_, structure = islice(made, 4)
    assert "of 12 coordinates only neighbours" in structure.symmetries.searched
    assert len(structure.symmetries.invariants) == 3


def test_null_space_against_sympy():
    """A matrix of rank 2 with a parameter, and one row that holds for no vector of the rest."""
    x = 7  # stands for a parameter
    p = {((x, 1),): 1}
    one = {(): 1}
    rows = [{0: one, 1: p, 2: {(): 2}}, {1: {(): Fraction(1, 3)}, 2: p, 3: one}]
    rows.append({0: p, 1: {((x, 2),): 1, (): Fraction(1, 3)}, 2: {((x, 1),): 3}, 3: one})
    X = sympy.Symbol("X")

    def value(entry):
        return sum(sympy.Rational(c) * X ** dict(m).get(x, 0) for m, c in entry.items())

    matrix = sympy.Matrix(3, 5, lambda i, j: value(rows[i].get(j, {})))
    basis = null_space(rows, 5)
    assert len(basis) == 5 - matrix.rank() == 3
    vectors = [sympy.Matrix([value(v.get(c, {})) for c in range(5)]) for v in basis]
    assert sympy.Matrix.hstack(*vectors).rank() == 3
    assert all(sympy.expand(matrix * v).is_zero_matrix for v in vectors)
    assert null_space([*rows, {2: p}, {3: p}, {4: one}], 5) == []


def test_a_copy_of_a_graph_leaves_the_graph_alone():
    *_, equations = islice(stages(Source("x.lag", f"model test\n{TOP}"), {}), 3)
    g, copy = equations.graph, equations.graph.copy()
    before = len(g)
    node = copy.multiply(copy.number(12345), equations.energy)
    assert node >= before == len(g)
    assert g.number(12345) == before  # the same number as in the copy, and not from there
