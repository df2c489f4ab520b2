"""Constraints and rolling: the forces and multipliers against the equations of d'Alembert, solved
whole by numpy from the unconstrained model's M and f, J by hand and its rate by differences."""

import math
import random

import numpy
import pytest
from c_harness import COMPILERS, Loaded

import pkgen
from conftest import case
from pkgen.compiler import compile_model
from pkgen.explain.flat import freedom
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.graph.rounding import sizes
from pkgen.source import ModelError, Source

# A rod whose length breathes, a plane that is inclined, and a blade that turns with a body; M
# depends on q, there is friction, and a state pulls.
BODY = """\
param m = 1.3 in (0, inf)
param k = 0.7
coord x, y, z, a
state s
rate s = x' - k*s
rotation R
let w = omega(R)
kinetic m/2*(x'^2 + y'^2 + z'^2) + (2 + sin(x))/2*a'^2 + a'*z'*cos(a)/3
kinetic 0.9/2*w.x^2 + 1.7/2*w.y^2 + 2.1/2*w.z^2
potential 2.385*y + x*z^2 + (R*[0.3, 0.2, 0.9]).z
dissipation k/2*x'^2
force z = s
force R = [0.1, 0, 0.2*t]
"""
ROWS = """\
constraint rod: x^2 + y^2 + z^2 = (1.5 + 0.1*sin(2*t))^2
constraint slope: z = 0.3*x + cos(a) + k
constraint pin: dot(R*[1, 0, 0], [x, y, z]) = 0.4
rolling blade: x'*sin(a) - y'*cos(a) + 0.5*w.z = 0.2*t
start x = 1.1, y = 0.7, z = 0.9, a = 0.4  # somewhere, where rows are far from dependent
"""
OUTPUTS = "observe tension = 2*lambda_rod\nobserve side = lambda_blade + p_a\n"


def without_start_check(monkeypatch):
    """The rows are right anywhere; a start on all of them takes a computer to find."""
    monkeypatch.setattr("pkgen.middle.derive.derive.at_the_start", lambda g, rows, *_: (rows, []))


def rotated(Q, b):
    w, u = Q[0], numpy.array(Q[1:])
    return (w * w - u @ u) * b + 2 * (u @ b) * u + 2 * w * numpy.cross(u, b)


def rates(t, q, v, Q):
    """J, and J v + j0, of ROWS, written down by hand; Q of any length, as the kernels take it."""
    x, y, z, a = q
    place = numpy.array([x, y, z])
    J = numpy.zeros((4, 7))
    J[0, :3] = 2 * place
    J[1, :4] = [-0.3, 0, 1, math.sin(a)]
    J[2, :3] = rotated(Q, numpy.array([1.0, 0, 0]))
    for i, axis in enumerate(numpy.eye(3)):
        J[2, 4 + i] = rotated(Q, numpy.cross(axis, [1.0, 0, 0])) @ place
    J[3, [0, 1, 6]] = math.sin(a), -math.cos(a), 0.5
    length, faster = 1.5 + 0.1 * math.sin(2 * t), 0.2 * math.cos(2 * t)
    return J, J @ v + [-2 * length * faster, 0, 0, -0.2 * t]


def quaternion_rate(Q, w):
    return numpy.array([-(Q[1:] @ w), *(Q[0] * w + numpy.cross(Q[1:], w))]) / 2


def somewhere(draw: random.Random):
    Q = numpy.array([draw.gauss(0, 1) for _ in range(4)])
    q = numpy.array([draw.uniform(-1, 1) for _ in range(4)])
    v = numpy.array([draw.uniform(-2, 2) for _ in range(7)])
    return draw.uniform(0, 2), q, v, Q / numpy.linalg.norm(Q), draw.uniform(-1, 1)


def called(c: Loaded, kernel: str, t, q, v, Q, s):
    return c.call(kernel, t, [*q, *[0.0] * 8], [*v, *Q, s])[1]


@pytest.mark.parametrize("compiler", COMPILERS)
def test_forces_are_dalemberts(tmp_path, compiler, monkeypatch):
    without_start_check(monkeypatch)
    texts = ("model free_of_all\n" + BODY, "model bound\n" + BODY + ROWS + OUTPUTS)
    free, bound = (
        Loaded(compile_model(Source("model.lag", text)).program, tmp_path, compiler)
        for text in texts
    )
    draw = random.Random(2385)
    for _ in range(20):
        state = somewhere(draw)
        t, q, v, Q, _ = state
        M = numpy.array(called(free, "mass", *state)[0]).reshape(12, 12)[:7, :7]
        f = numpy.array(called(free, "force", *state)[0])[:7]
        J, residual = rates(t, q, v, Q)
        h = 1e-5

        def later(step, t=t, q=q, v=v, Q=Q):
            turned = Q + step * quaternion_rate(Q, v[4:])
            return rates(t + step, q + step * v[:4], v, turned)[1]

        gamma = (later(h) - later(-h)) / (2 * h)  # exact to h^2: the rest is rounding
        whole = numpy.block([[M, -J.T], [J, numpy.zeros((4, 4))]])
        solution = numpy.linalg.solve(whole, [*f, *-gamma])
        a, multipliers = solution[:7], solution[7:]
        size = numpy.abs(solution).max()
        found = called(bound, "acceleration", *state)[0]
        assert found[:7] == pytest.approx(a, abs=1e-8 * size)
        assert called(bound, "multipliers", *state)[0] == pytest.approx(
            multipliers, abs=1e-8 * size
        )
        assert numpy.abs(multipliers).min() > 1e-6
        rows, left = called(bound, "constraint_jacobian", *state)
        assert numpy.array(rows).reshape(4, 12)[:, :7] == pytest.approx(J, abs=1e-14)
        assert not numpy.array(rows).reshape(4, 12)[:, 7:].any()
        assert left == pytest.approx(residual, abs=1e-14)
        tension, side = called(bound, "observe", *state)[0]
        p = called(bound, "unconstrained", *state)[0]
        assert tension == pytest.approx(2 * multipliers[0], abs=1e-8 * size)
        assert side == pytest.approx(multipliers[3] + p[3], abs=1e-8 * size)
        force = called(bound, "force", *state)[0][:7]
        assert force == pytest.approx(f + J.T @ multipliers, abs=1e-7 * size)
        # The Gauss methods solve p' = pdot: there the forces have to be too.
        (free_p, free_pdot), (p, pdot) = (called(c, "canonical", *state) for c in (free, bound))
        assert p == pytest.approx(free_p, abs=1e-12)
        assert pdot[:7] == pytest.approx(free_pdot[:7] + J.T @ multipliers, abs=1e-7 * size)
        assert pdot[7:] == pytest.approx(free_pdot[7:], abs=1e-12)
        phi = called(bound, "constraint", *state)[0]
        x, y, z, angle = q
        place = numpy.array([x, y, z])
        assert phi == pytest.approx(
            [
                place @ place - (1.5 + 0.1 * math.sin(2 * t)) ** 2,
                z - 0.3 * x - math.cos(angle) - 0.7,
                rotated(Q, numpy.array([1.0, 0, 0])) @ place - 0.4,
            ],
            abs=1e-14,
        )


def test_terms_are_the_sizes_of_places_and_of_rates(tmp_path, monkeypatch):
    """As rounding.py has them in Python; and not far from what is seen in the text."""
    without_start_check(monkeypatch)
    c = Loaded(compile_model(Source("model.lag", "model bound\n" + BODY + ROWS)).program, tmp_path)
    e, g = c.program.equations, c.program.equations.graph
    draw = random.Random(7)
    for _ in range(5):
        t, q, v, Q, s = somewhere(draw)
        places, rows = called(c, "residual_scale", t, q, v, Q, s)
        known = {Symbol(Kind.TIME, 0): t, Symbol(Kind.PARAMETER, 0): 1.3}
        known |= {Symbol(Kind.PARAMETER, 1): 0.7}
        known |= {Symbol(Kind.COORDINATE, i): x for i, x in enumerate(q)}
        known |= {Symbol(Kind.RATE, i): x for i, x in enumerate([*v, *Q, s])}
        for found, nodes in ((places, e.constraints.positions), (rows, e.constraints.residual)):
            assert found == pytest.approx(evaluate(g, sizes(g, nodes), known), rel=1e-13)
        (x, _, z, a), (vx, vy, vz, va, _, _, wz) = map(abs, q), map(abs, v)
        sine, cosine = abs(math.sin(a)), abs(math.cos(a))
        slope = z + 0.3 * x + cosine + sine * a + 0.7
        faster = vz + 0.3 * vx + (2 * sine + cosine * a) * va
        blade = vx * (2 * sine + cosine * a) + vy * (2 * cosine + sine * a) + 0.5 * wz + 0.2 * t
        for size, seen in ((places[1], slope), (rows[1], faster), (rows[3], blade)):
            assert seen <= 1.0001 * size < 3 * seen


def test_unconstrained_is_the_model_without_its_constraints(tmp_path, monkeypatch):
    without_start_check(monkeypatch)
    texts = ("model free_of_all\n" + BODY, "model bound\n" + BODY + ROWS)
    free, bound = (
        Loaded(compile_model(Source("model.lag", text)).program, tmp_path) for text in texts
    )
    state = somewhere(random.Random(3))
    for kernel in ("unconstrained", "inertia"):
        mine, theirs = (called(c, kernel, *state) for c in (bound, free))
        for one, other in zip(mine, theirs, strict=True):
            assert one == pytest.approx(other, rel=1e-13, abs=1e-13)


def test_what_moves_is_counted(monkeypatch):
    without_start_check(monkeypatch)
    made = compile_model(Source("model.lag", "model bound\n" + BODY + ROWS))
    assert freedom(made.equations) == [
        *("7 rates", "3 constraints", "1 rolling", "3 degrees of freedom"),
        *("1 rotation", "1 state"),
    ]


def facts(text: str):
    return compile_model(Source("model.lag", text)).structure


def test_what_is_proved_with_constraints():
    plane = "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential y\nstart x = 1\n"
    rod = facts("model rod\n" + plane + "constraint rod: x^2 + y^2 = 1\n")
    assert rod.conservative and rod.autonomous
    assert not rod.variational and not rod.separable
    moved = facts("model moved\n" + plane + "constraint rod: x^2 + y^2 = 1 + t^2\n")
    assert not moved.conservative and not moved.autonomous
    # What moves by itself does work, though nothing in it knows the time.
    belt = facts("model belt\n" + plane + "rolling belt: x' = y' + 0\nconserve c = energy\n")
    assert belt.conservative
    driven = "model driven\n" + plane.replace("x = 1", "x' = 1") + "rolling belt: x' = 1 + y'\n"
    assert not facts(driven).conservative
    # Of what an input or the time turns round nobody knows, though it does no work.
    for by in ("u", "t"):
        steered = f"model steered\ninput u\n{plane}rolling blade: y' = {by}*x'\n"
        assert not facts(steered).conservative and not facts(steered).autonomous


WRONG = [
    ("constraint a: x = 1\n", "the start breaks the constraint 'a': left minus right is -1, not 0"),
    ("rolling a: x' = 2\n", "the start breaks the rolling 'a': left minus right is -2, not 0"),
    (
        "constraint a: x = 2*t\n",
        "the start breaks the constraint 'a': its rate is -2, not 0",
    ),
    (
        "constraint a: x = 1\nconstraint b: x + x^2 = 1\n",
        "the constraint 'b' contradicts 'a': they leave the same rates no freedom",
    ),
    (
        "constraint a: x^2 + y^2 = 0\n",
        "the constraint 'a' has no force at the start: its row is 0 there",
    ),
    ("rolling a: x'*y' = 0\n", "the rolling 'a' has no force at the start: its row is 0 there"),
    ("rolling a: x'*y' = 2\nstart x' = 1, y' = 2\n", "the rolling 'a' is not affine in the rates"),
    (
        "constraint a: x - x = 0*y\n",
        "the constraint 'a' holds or fails whatever the motion",
    ),
    (
        "let d = x - x\nconstraint a: 2*d = 0\n",
        "the constraint 'a' holds or fails whatever the motion",
    ),
]


@pytest.mark.parametrize(("rows", "said"), WRONG)
def test_constraints_that_cannot_be(rows, said):
    text = "model wrong\ncoord x, y, z\nkinetic (x'^2 + y'^2 + z'^2)/2\n" + rows
    with pytest.raises(ModelError) as caught:
        compile_model(Source("model.lag", text))
    shown = caught.value.text()
    assert said in shown
    assert "^" in shown and "model.lag:" in shown


FLAT = (
    "model flat\nparam a = 0.1\nparam b = 0.2\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential x\n"
)


@pytest.mark.parametrize(
    ("row", "x"), [("(x - 0.3)^2 = 0", "a + b"), ("cos(x) = -1", "3.141592653589793")]
)
def test_a_row_that_is_rounding_has_no_force(row, x):
    said = "has no force at the start: its row is 0 there"
    with pytest.raises(ModelError) as caught:
        compile_model(Source("flat.lag", f"{FLAT}constraint s: {row}\nstart x = {x}\n"))
    assert said in caught.value.text()
    small = f"{FLAT}constraint s: 1e-12*x = 3e-13\nstart x = {x}\n"
    if x == "a + b":
        compile_model(Source("small.lag", small))


@pytest.mark.filterwarnings("ignore:.*never used")
def test_a_row_that_is_rounding_has_no_force_by_options(tmp_path):
    path = tmp_path / "flat.lag"
    path.write_text(f"{FLAT}constraint s: (x - b)^2 = 4\nstart x = b + 2\n")
    model = pkgen.load(str(path))
    model.run(until=1)
    path.write_text(f"{FLAT}constraint s: (x - 0.3)*(y - 0.4) = 0\nstart x = 1, y = 0.4\n")
    with pytest.raises(pkgen.RunError, match="nothing that moves enters s"):
        pkgen.load(str(path)).run(until=1, start={"x": 0.1 + 0.2, "y": 0.4})


def test_an_input_leaves_the_start_to_the_run():
    compile_model(
        Source(
            "model.lag",
            "model later\ncoord x, y\ninput u\nkinetic (x'^2 + y'^2)/2\nconstraint a: x = u + 1\n",
        )
    )


def test_no_canonical_form():
    plane = "coord x, y\nkinetic (x'^2 + y'^2)/2\nstart x = 1\n"
    for text, why in (
        ("model a\n" + plane + "constraint rod: x^2 + y^2 = 1\n", "a constraint leaves q and p"),
        ("model b\n" + plane + "rotation R\nkinetic dot(omega(R), omega(R))\n", "body rates are"),
    ):
        with pytest.raises(ModelError) as caught:
            compile_model(Source("model.lag", text), canonical=True)
        assert why in caught.value.diagnostics[0].message


RAIL = case("rail")


@pytest.mark.parametrize("method", ["dopri5", "dop853", "gauss", "radau"])
def test_a_row_at_rest_but_for_rounding_ends_no_run_that_looks_for_events(tmp_path, method):
    (tmp_path / "rail.lag").write_text(RAIL)
    rows = pkgen.load(str(tmp_path / "rail.lag")).run(until=1, at="c", method=method)
    assert abs(rows["t"][-1] - 0.8536497397) < 1e-8


def test_inertia_by_an_input_is_not_asked_for_at_the_start() -> None:
    text = "model rod\ninput push\ncoord x, y\nkinetic (1 + push^2)*(x'^2 + y'^2)/2\n"
    text += "constraint rod: x^2 + y^2 = 1\nstart x = 1\n"
    assert compile_model(Source("rod.lag", text)).equations.constraints
