"""Which particles a kinetic energy is of, by its text; and that the kernel of a model has them."""

from fractions import Fraction
from pathlib import Path

import pytest

from conftest import ROOT
from pkgen.back.kernels import KERNELS
from pkgen.compiler import check_model, compile_model
from pkgen.front.read import read
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import ZERO
from pkgen.middle.derive.derive import derive
from pkgen.middle.particles import places as at_places
from pkgen.middle.particles import text as reading
from pkgen.middle.points.samples import defaults
from pkgen.source import Source

PLANE = "coord x, y\n"
POLAR = "coord r, phi\nparam m = 2 in (0, inf)\nstart r = 1\n"
FAMILY = "size N = 3\nparam m[i = 1..N] = i in (0, inf)\ncoord x[1..N], y[1..N], z[1..N]\n"
FOUND = {  # a model, and how many particles it has
    PLANE + "kinetic (x'^2 + y'^2)/2": 1,
    PLANE + "kinetic x'^2/2\nkinetic y'*y'/2": 1,
    PLANE + "let v2 = x'^2 + y'^2\nkinetic 0.5*v2": 1,
    PLANE + "let r = [x, y, 0]\nkinetic dot(r', r')/2": 1,
    PLANE + "let r = [x, y, 0]\nkinetic norm(r')^2/2": 1,
    PLANE + "let r = [x, y, 0]\nkinetic ((r.x)'^2 + (r.y)'^2)/2": 1,
    "coord a_x, a_y, b_x, b_y\nkinetic (a_x'^2 + a_y'^2)/2 + b_x'^2 + b_y'^2": 2,
    POLAR + "let x = r*cos(phi)\nlet y = r*sin(phi)\nkinetic m/2*(x'^2 + y'^2)": 1,
    POLAR + "kinetic m/2*((r*cos(phi))'^2 + (r*sin(phi))'^2)": 1,
    POLAR + "kinetic m/2*(r'^2 + r^2*phi'^2)": 1,
    POLAR + "kinetic m/2*r'^2 + m/2*(r*phi')^2": 1,
    "coord r, a, b\nstart r = 1, a = 1\nkinetic (r'^2 + r^2*a'^2 + r^2*sin(a)^2*b'^2)/2": 1,
    FAMILY + "kinetic sum(m[i]/2*(x[i]'^2 + y[i]'^2 + z[i]'^2), i = 1..N)": 3,
    FAMILY + "kinetic sum(m[i]/2*x[i]'^2, i = 1..N) + sum(m[i]/2*y[i]'^2, i = 1..N)\n"
    "kinetic sum(m[i]/2*z[i]'^2, i = 1..N)": 3,
}
PENDULUM = "param m = 2 in (0, inf)\nparam l = 3 in (0, inf)\ncoord theta\n"
CIRCLE = "let x = l*sin(theta)\nlet y = -l*cos(theta)\n"
DOUBLE = """param m1 = 1 in (0, inf)
param m2 = 2 in (0, inf)
param l1 = 3 in (0, inf)
param l2 = 4 in (0, inf)
coord a, b
let x1 = l1*sin(a)
let y1 = -l1*cos(a)
let x2 = x1 + l2*sin(b)
let y2 = y1 - l2*cos(b)
start a = 1, b = 2
"""
OF_DOUBLE = "m1/2*l1^2*a'^2 + m2/2*(l1^2*a'^2 + l2^2*b'^2 + 2*l1*l2*a'*b'*cos(a - b))"
DUMBBELL = """param m1 = 1 in (0, inf)
param m2 = 2 in (0, inf)
coord X, Y, r, phi
let x1 = X - m2/(m1 + m2)*r*cos(phi)
let y1 = Y - m2/(m1 + m2)*r*sin(phi)
let x2 = X + m1/(m1 + m2)*r*cos(phi)
let y2 = Y + m1/(m1 + m2)*r*sin(phi)
start r = 1
kinetic (m1 + m2)/2*(X'^2 + Y'^2) + m1*m2/(m1 + m2)/2*(r'^2 + r^2*phi'^2)
"""
TURNING = "((x' - y)^2 + (y' + x)^2)/2"
STARS = "observe X = x*cos(t) - y*sin(t)\nobserve Y = x*sin(t) + y*cos(t)\n"
LINKS = """size N = 5
coord a[1..N]
let x[k = 1..N] = sum(sin(a[i]), i = 1..k)
let y[k = 1..N] = -sum(cos(a[i]), i = 1..k)
start a[i = 1..N] = i/10
kinetic sum((N + 1 - i)/2*a[i]'^2, i = 1..N)
kinetic sum((N + 1 - j)*a[i]'*a[j]'*cos(a[i] - a[j]), i = 1..N, j = i+1..N)
"""
AT = {  # a model, the places of its particles, and their masses with its parameters
    "coord x, z\nkinetic (x'^2 + z'^2)/2": {"(x, z)": 1},
    "coord y, z\nkinetic y'^2 + z'^2": {"(y, z)": 2},
    "coord rx, ry, rz\nkinetic (rx'^2 + ry'^2 + rz'^2)/2": {"(rx, ry, rz)": 1},
    "size N = 2\ncoord x1[1..N], y1[1..N]\nkinetic sum(i*(x1[i]'^2 + y1[i]'^2), i = 1..N)": {
        "(x1[1], y1[1])": 2,
        "(x1[2], y1[2])": 4,
    },
    "size N = 2\ncoord x[1..N], y[1..N]\nlet r[i = 1..N] = [x[i], y[i], 0]\n"
    "lagrangian sum(dot(r[i]', r[i]')/2, i = 1..N) + y[1]": {"r[1]": 1, "r[2]": 1},
    PLANE + "let v = sqrt(x'^2 + y'^2)\nkinetic 2*v^2": {"(x, y)": 4},
    PLANE + "let v = [x', y', 0]\nkinetic dot(v, v)/2": {"(x, y)": 1},
    PLANE + "let r = [2*x, y, 0]\nkinetic x'^2*5/2 + y'^2": {"(x, y)": 1, "r": 1},
    PLANE + "let vx = x'\nlet vy = y'\nkinetic (vx^2 + vy^2)/2": {"(x, y)": 1},
    PLANE + "let E = (x'^2 + y'^2)/2\nkinetic E": {"(x, y)": 1},
    PLANE + "let z = sin(x)*y\nkinetic ((x' + y')^2 + (x' - y')^2)/4\npotential z": {"(x, y)": 1},
    "coord u, w\nlet x = u\nlet y = w\nkinetic (u'^2 + w'^2)/2": {"(x, y)": 1},
    "coord x\nlet y = x^2\nkinetic (1 + 4*x^2)*x'^2/2": {"(x, y)": 1},
    "coord q\nstart q = 1\nlet x = 1/q\nlet y = log(q)\nkinetic (1/q^4 + 1/q^2)*q'^2/2": {
        "(x, y)": 1
    },
    "coord u, v\nlet x = cosh(u)*cos(v)\nlet y = sinh(u)*sin(v)\nstart u = 1, v = 1\n"
    "kinetic (sinh(u)^2 + sin(v)^2)*(u'^2 + v'^2)/2": {"(x, y)": 1},
    "coord r, phi\nstart r = 1\nlet v = sqrt(r'^2 + r^2*phi'^2)\nkinetic v^2/2": {"(r, phi)": 1},
    "coord r, phi\nstart r = 1\nlagrangian (r'^2 + r^2*phi'^2)/2 + 1/r": {"(r, phi)": 1},
    PENDULUM + CIRCLE + "kinetic m/2*l^2*theta'^2": {"(x, y)": 2},
    PENDULUM + "let r = [l*sin(theta), 0, -l*cos(theta)]\nkinetic m/2*l^2*theta'^2": {"r": 2},
    PENDULUM + "kinetic m/2*l^2*theta'^2\nobserve x = l*sin(theta)\nobserve z = -l*cos(theta)": {
        "(x, z)": 2
    },
    DOUBLE + "kinetic " + OF_DOUBLE: {"(x1, y1)": 1, "(x2, y2)": 2},
    DOUBLE + "lagrangian -y1*m1 + " + OF_DOUBLE: {"(x1, y1)": 1, "(x2, y2)": 2},
    DOUBLE + "let cx = (x1*m1 + x2*m2)/(m1 + m2)\nlet cy = (y1*m1 + y2*m2)/(m1 + m2)\n"
    "let dx = x2 - x1\nlet dy = y2 - y1\nkinetic " + OF_DOUBLE: {"(x1, y1)": 1, "(x2, y2)": 2},
    DOUBLE.replace("m2 = 2 in (0", "m2 = 0 in [0") + "kinetic " + OF_DOUBLE: {
        "(x1, y1)": 1,
        "(x2, y2)": 0,
    },
    DUMBBELL: {"(x1, y1)": 1, "(x2, y2)": 2},
    LINKS: {f"(x[{k}], y[{k}])": 1 for k in range(1, 6)},
    PLANE + STARS + "lagrangian " + TURNING: {"(X, Y)": 1},
    "param m = 1 [kg]\nparam l = 2 [m]\ncoord theta [rad]\nlet nx = sin(theta)\n"
    "let ny = -cos(theta)\nlet x = l*nx\nlet y = l*ny\nkinetic m/2*l^2*theta'^2": {"(x, y)": 1},
}
BEYOND = {  # a model of one particle, and what is not its m/2 r'^2
    PLANE + "lagrangian " + TURNING: "linear in the rates",
    PLANE + "kinetic " + TURNING: "linear in the rates",
    PLANE + "lagrangian (x'^2 + y'^2)/2 + x*y' - y*x' - x^2": "linear in the rates",
    "coord r, phi\nstart r = 1\nlagrangian (r'^2 + r^2*phi'^2)/2 + r^2*phi'": "linear in the rates",
    PENDULUM + CIRCLE + "kinetic m/2*l^2*(theta'^2 + 4*sin(theta)^2)": "terms without rates",
}
NONE, OTHER = "it names no place in a plane or in space", "is no sum of m/2 r'^2 over places"
NOT = {  # and of others where they say what
    "coord x\nkinetic x'^2/2": NONE,
    "coord x1, x2\nkinetic (x1'^2 + x2'^2)/2": NONE,
    "coord u, w\nkinetic (u'^2 + w'^2)/2": NONE,
    "coord q[1..2]\nkinetic q[1]'^2/2 + q[2]'^2/2": NONE,
    PENDULUM + "kinetic m/2*l^2*theta'^2": NONE,
    "state s\nrate s = -s\nstart s = 1": NONE,
    "coord a_x, a_y [rad]\nkinetic (1 [kg*m^2])/2*(a_x'^2 + a_y'^2)": NONE,  # angles
    PLANE + "kinetic x'^2 + y'^2/2": OTHER,
    "coord x, y, z\nkinetic x'^2 + y'^2 + z'^2/2": OTHER,
    PLANE + "kinetic (x'^2 + y'^2 + x'*y')/2": OTHER,
    PLANE + "let r = [2*x, y, 0]\nkinetic x'^2/2 + y'^2": OTHER,  # the mass at r is negative
    PLANE + "lagrangian -sqrt(1 - x'^2 - y'^2)": "not of the second degree in the rates",
    PLANE + "kinetic (1 + x^2)*(x'^2 + y'^2)/2": "a mass that varies",
    PLANE + "state m\nrate m = -1\nstart m = 9\nkinetic m*(x'^2 + y'^2)/2": "a mass that varies",
    POLAR + "kinetic m/2*(r'^2 + 2*r^2*phi'^2)": NONE,
    PLANE + "coord a\nkinetic (x'^2 + y'^2)/2 + a'^2": OTHER,
    PENDULUM + CIRCLE + "kinetic m*l^2*theta'^2*cosh(theta)": OTHER,
    DOUBLE + "kinetic " + OF_DOUBLE.replace("2*l1*l2", "l1*l2"): OTHER,
}
ALL = frozenset(KERNELS) - {"hamiltonian", "hamilton", "hamilton_force"}


def particles(text: str, kernels: frozenset[str] | None = ALL):
    compilation = compile_model(Source("a.lag", f"model a\n{text}\n"), kernels=kernels)
    return compilation.equations.particles, compilation


@pytest.mark.parametrize("text", FOUND)
def test_found(text: str) -> None:
    found, compilation = particles(text)
    assert found.why == "" and len(found.masses) == FOUND[text]
    assert f".particles = {{.n = {FOUND[text]}," in compilation.files["a_system.c"]


@pytest.mark.parametrize("text", NOT)
def test_not_of_particles(text: str) -> None:
    found, compilation = particles(text)
    assert NOT[text] in found.why and not found.masses
    assert compilation.model.source.place(found.span).startswith("a.lag:")
    assert "particles" not in compilation.files["a_system.c"]


@pytest.mark.parametrize("text", AT)
def test_at_places_that_are_named(text: str) -> None:
    found, compilation = particles(text)
    equations = compilation.equations
    values = defaults(equations.graph, equations.parameters)
    masses = evaluate(equations.graph, found.masses, values)
    assert found.why == found.beyond == ""
    assert dict(zip(found.names, masses, strict=True)) == pytest.approx(AT[text], rel=1e-14)


@pytest.mark.parametrize("text", BEYOND)
def test_what_is_beyond_is_said(text: str) -> None:
    found, _ = particles(text)
    assert BEYOND[text] in found.beyond and len(found.names) == 1


def test_what_is_read_is_proved(monkeypatch) -> None:
    # A reader that takes the angle for the radius finds particles of another kinetic energy.
    right = reading._polar
    monkeypatch.setattr(reading, "_polar", lambda x, group: right(x, group[::-1]) or wrong(group))

    def wrong(group):
        return (*(square.place for square in group), ZERO)

    found, _ = particles(POLAR + "kinetic m/2*(r'^2 + r^2*phi'^2)")
    assert not found.masses


def test_what_is_solved_for_is_proved(monkeypatch) -> None:
    # Masses a part in a thousand too large.
    right = at_places.masses_of

    def heavier(g, *rest):
        return [(a, g.multiply(g.number(Fraction(1001, 1000)), m)) for a, m in right(g, *rest)]

    monkeypatch.setattr(at_places, "masses_of", heavier)
    found, _ = particles(PENDULUM + CIRCLE + "kinetic m/2*l^2*theta'^2")
    assert "sum of m/2 r'^2 over (x, y) is not proved" in found.why and not found.masses


MODELS = ROOT / "models"
LINES = {"thrown_stone", "coupled_oscillators", *(p.stem for p in MODELS.glob("chains/*.lag"))}
LINES = LINES - {"hanging", "rope"} | {"motor", "two_motors", "bilinear_spring", "coarse_sensor"}
LINES |= {"guiding_centre", "hyperbolic_motion", "point_vortices"}  # coordinates, no places
LINES |= {"bouncing_ball", "box_on_incline", "newton_cradle", "stick_slip_belt"}
UNNAMED = {"two_pendulums", "heavy_top"}  # where its pivots are is not said; a rigid body
# Points, and rods that are as points; the others turn, roll, or are states alone.
RODS = {"pendulum_rod", "double_pendulum_rods", "slider_crank", "two_links", "weather_vane"}
BODIES = {p.stem for of in ("bodies", "constrained") for p in MODELS.glob(f"{of}/*.lag")} - RODS
BODIES |= {"rocking_block"}


@pytest.mark.parametrize("path", sorted(MODELS.rglob("*.lag")), ids=lambda path: path.stem)
def test_models(path: Path) -> None:
    model, _ = check_model(read(path))
    found = derive(model, kernels=frozenset({"particles"})).particles
    assert bool(found.masses) == (path.stem not in LINES | UNNAMED | BODIES), found.why
    turning = {"restricted_three_body", "foucault_spherical", "larmor"}
    assert bool(found.beyond) == (path.stem in turning)


def test_only_where_they_are_asked_for() -> None:
    found, compilation = particles(PLANE + "kinetic (x'^2 + y'^2)/2", None)
    assert found is None and "particles" not in compilation.files["a_system.c"]
    assert check_model(compilation.model.source)
