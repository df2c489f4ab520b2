"""Rotations: their equations of motion against Lagrange's in three angles, by SymPy.

The oracle knows nothing of body rates and quaternions: near an attitude Q0 it turns by three
angles s, writes L in q, s, q', s' with omega = J(s) s' read off R^T R', derives Lagrange's
equations for s and solves them at s = 0, where omega = J s' and omega' = J s'' + J' s'.
"""

import random

import numpy
import pytest
import sympy as sp
from building import Needing
from c_harness import COMPILERS, Loaded

from conftest import case
from pkgen.back.c.lower import lower
from pkgen.compiler import compile_model
from pkgen.middle.analyze.analyze import analyze
from pkgen.middle.derive.states import as_rates
from pkgen.source import Source

# A body that hangs off its centre on a moving support, with a potential of its attitude, a torque
# and friction; and beside it a top.
HUNG = case("attitudes_hung")


def turned(q: sp.Matrix) -> sp.Matrix:
    """R of a unit quaternion w, x, y, z: the textbook matrix of 1 - 2(y^2 + z^2)."""
    w, x, y, z = q
    return sp.Matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def about(axis: int, angle: sp.Expr) -> sp.Matrix:
    c, s = sp.cos(angle), sp.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = sp.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def spin_of(turn: sp.Matrix, s: list[sp.Symbol]) -> sp.Matrix:
    """J(s), so that the vector of R^T R' is J s'."""
    columns = []
    for angle in s:
        spin = turn.T * turn.diff(angle)
        columns.append(sp.Matrix([spin[2, 1], spin[0, 2], spin[1, 0]]))
    return sp.Matrix.hstack(*columns)


@pytest.fixture(scope="module")
def by_angles():
    """x'', y'', omega' of HUNG from its Lagrangian, at an attitude and a state."""
    t, x, y, *s = sp.symbols("t x y s0 s1 s2")
    rates = sp.symbols("xd yd d0 d1 d2")
    base = sp.Matrix(3, 3, sp.symbols("b0:9"))
    turn = about(0, s[0]) * about(1, s[1]) * about(2, s[2])
    every = [x, y, *s]

    def rate(node):
        return node.jacobian(every) * sp.Matrix(rates)

    J = spin_of(turn, s)
    w = J * sp.Matrix(rates[2:])
    r = sp.Matrix([x, y, sp.Rational(3, 10) * x]) + base * turn * sp.Matrix([4, -2, 7]) / 10
    m, g, c = sp.Rational(13, 10), sp.Rational(2385, 1000), sp.Rational(17, 100)
    T = m / 2 * rate(r).dot(rate(r)) + rates[0] ** 2 / 4
    T += (9 * w[0] ** 2 + 17 * w[1] ** 2 + 21 * w[2] ** 2) / 20 + 3 * w[0] * w[2] / 10
    V = m * g * r[2]
    V += x**2 * (base * turn * sp.Matrix([0, 1, 0])).dot(sp.Matrix([3, 5, 10])) / 10
    D = c / 2 * w.dot(w) + c * rates[1] * w[0]
    torque = sp.Matrix([x, rates[1] / 5, w[1] * t])
    applied = sp.Matrix([3 * w[2] / 10, 0, *(J.T * torque)])  # a torque's part in each turn by s'
    L, D = sp.Matrix([T - V]), sp.Matrix([D])
    p = L.jacobian(rates).T
    M = p.jacobian(rates)
    f = L.jacobian(every).T - D.jacobian(rates).T + applied - p.jacobian(every) * sp.Matrix(rates)
    twist = rate(w)  # omega' = J s'' + J' s'
    at_rest = dict.fromkeys(s, 0)
    arguments = [t, x, y, *rates, *base]
    compute = sp.lambdify(arguments, [a.subs(at_rest) for a in (M, f, J, twist)], cse=True)

    def found(quaternion, q, v, time) -> list[float]:
        entries = turned(sp.Matrix(quaternion))
        M, f, J, twist = compute(time, *q, *v, *map(float, entries))
        a = numpy.linalg.solve(M, f).ravel()
        return [*a[:2], *(J @ a[2:] + twist.ravel())]

    return found


def loaded(text: str, directory, compiler: str = "gcc"):
    made = compile_model(Source("model.lag", text))
    return made, Loaded(made.program, directory, compiler)


@pytest.fixture(scope="module")
def hung(tmp_path_factory) -> Loaded:
    """HUNG with outputs."""
    text = HUNG + (
        "observe e = euler(R)\nobserve b = tait_bryan(R)\nobserve out = R*[1, 2, 3]\n"
        "observe back = inverse(R)*[1, 2, 3]\nobserve both = R*rot([0, 0, 1], 0.3)*[1, 2, 3]\n"
    )
    return loaded(text, tmp_path_factory.mktemp("hung"))[1]


def somewhere(draw: random.Random) -> tuple[list[float], list[float], list[float], float]:
    quaternion = [draw.gauss(0, 1) for _ in range(4)]
    size = sum(a * a for a in quaternion) ** 0.5
    q = [draw.uniform(-1, 1) for _ in range(2)]
    v = [draw.uniform(-2, 2) for _ in range(5)]
    return [a / size for a in quaternion], q, v, draw.uniform(0, 2)


@pytest.mark.parametrize("compiler", COMPILERS)
def test_accelerations_are_lagranges_in_angles(tmp_path, compiler, by_angles):
    _, c = loaded(HUNG, tmp_path, compiler)
    draw = random.Random(2385)
    for _ in range(20):
        quaternion, q, v, t = somewhere(draw)
        failed, (a,) = c.call("acceleration", t, [*q, *[0.0] * 7], [*v, *quaternion])
        assert not failed
        expected = by_angles(quaternion, q, v, t)
        assert a[:5] == pytest.approx(expected, rel=1e-12, abs=1e-12)
        assert min(map(abs, expected)) > 1e-4  # nothing is tested by being zero
        w, (x, y, z) = quaternion[0], quaternion[1:]
        spin = v[2:]
        half = [-x * spin[0] - y * spin[1] - z * spin[2], w * spin[0] + y * spin[2] - z * spin[1]]
        assert a[5:7] == pytest.approx([h / 2 for h in half], rel=1e-14)


def test_momentum_and_force_of_unconstrained_give_the_same_motion(hung):
    """d/dt of p along the motion is pdot: p and pdot are of the body frame, M a = dp/dt at a."""
    c = hung
    quaternion, q, v, t = somewhere(random.Random(7))
    state = [*q, *[0.0] * 7], [*v, *quaternion]
    _, (a,) = c.call("acceleration", t, *state)
    _, (p, pdot) = c.call("unconstrained", t, *state)
    _, (M,) = c.call("inertia", t, *state)
    h = 1e-6

    def later(step: float) -> list[float]:
        moved = [x + step * r for x, r in zip(q, v, strict=False)]
        rates = [r + step * b for r, b in zip(state[1], a, strict=True)]
        return c.call("unconstrained", t + step, [*moved, *[0.0] * 7], rates)[1][0]

    slope = [(x - y) / (2 * h) for x, y in zip(later(h), later(-h), strict=True)]
    assert slope == pytest.approx(pdot, rel=1e-8, abs=1e-8)
    assert max(abs(x) for x in p[:5]) > 0.1
    n = 9
    assert [M[i * n + j] for i in range(5) for j in range(5)] == pytest.approx(
        [M[j * n + i] for i in range(5) for j in range(5)]
    )
    assert [M[i * n + i] for i in range(5, n)] == [1.0] * 4


def test_energy_changes_by_what_is_applied(tmp_path):
    """dh/dt = v.(Q - dD/dv) where L does not know the time."""
    still = HUNG.replace("w.y*t", "w.y").replace("model hung", "model calm")
    _, c = loaded(still, tmp_path)
    quaternion, q, v, t = somewhere(random.Random(11))
    _, (a,) = c.call("acceleration", t, [*q, *[0.0] * 7], [*v, *quaternion])
    h = 1e-6

    def energy(step: float) -> float:
        moved = [x + step * r for x, r in zip(q, v, strict=False)]
        rates = [r + step * b for r, b in zip([*v, *quaternion], a, strict=True)]
        return c.call("energy", t, [*moved, *[0.0] * 7], rates)[0]

    xd, yd, *w = v
    friction = 0.17 * sum(b * b for b in w) + 2 * 0.17 * yd * w[0]
    power = 0.3 * w[2] * xd + q[0] * w[0] + 0.2 * yd * w[1] + w[1] * w[2] - friction
    assert (energy(h) - energy(-h)) / (2 * h) == pytest.approx(power, rel=1e-7)
    assert abs(power) > 0.01


def test_the_start_is_the_product_of_its_turns(hung):
    """Against matrices, by SymPy; the left one done last."""
    c = hung
    start_q, start_v = (c.library.hung_start, [0.0] * 9)
    import ctypes

    q, v = (ctypes.c_double * 9)(), (ctypes.c_double * 9)()
    start_q(c.params, q, v)
    found = turned(sp.Matrix(list(v)[5:]))
    n = sp.Matrix([1, 2, 3]) / sp.sqrt(14)
    cross = sp.Matrix([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    first = sp.eye(3) + sp.sin(0.7) * cross + (1 - sp.cos(0.7)) * cross**2
    expected = (first * about(1, 0.4)).evalf()
    assert list(found) == pytest.approx(list(map(float, expected)), abs=1e-15)
    assert list(v)[2:5] == [1, 2, 3]
    assert start_v == [0.0] * 9


def test_outputs_of_a_rotation(hung):
    """A vector of the body and back, and both sets of angles, against matrices."""
    c = hung
    draw = random.Random(5)
    for _ in range(20):
        quaternion, q, v, t = somewhere(draw)
        _, (out,) = c.call("observe", t, [*q, *[0.0] * 7], [*v, *quaternion])
        names = [x.name for x in c.program.equations.observed_names]
        found = dict(zip(names, out, strict=True))

        def vector(name, found=found):
            return [found[f"{name}.{axis}"] for axis in "xyz"]

        R = turned(sp.Matrix(quaternion))
        one = sp.Matrix([1, 2, 3])
        assert vector("out") == pytest.approx(list(R * one), abs=1e-14)
        assert vector("back") == pytest.approx(list(R.T * one), abs=1e-14)
        assert vector("both") == pytest.approx(list((R * about(2, 0.3) * one).evalf()), abs=1e-14)
        phi, theta, psi = vector("e")
        again = (about(2, phi) * about(0, theta) * about(2, psi)).evalf()
        assert list(again) == pytest.approx(list(R), abs=1e-14)
        assert 0 <= theta <= 3.15
        yaw, pitch, roll = vector("b")
        again = (about(2, yaw) * about(1, pitch) * about(0, roll)).evalf()
        assert list(again) == pytest.approx(list(R), abs=1e-14)
        assert abs(pitch) <= 1.58


def test_what_is_proved_of_a_free_body_and_a_top():
    free = compile_model(
        Source(
            "model.lag",
            "model freely\nparam A = 1\nparam B = 2\nparam C = 3\nrotation R\nlet w = omega(R)\n"
            "kinetic A/2*w.x^2 + B/2*w.y^2 + C/2*w.z^2\nconserve L = R*p_R\n"
            "conserve square = dot(p_R, p_R)\nconserve norm2 = R.w^2 + R.x^2 + R.y^2 + R.z^2\n"
            "conserve textbook = 2*(R.x*R.z - R.w*R.y)*p_R.x + 2*(R.y*R.z + R.w*R.x)*p_R.y"
            " + (1 - 2*(R.x^2 + R.y^2))*p_R.z  # L.z of quaternions of length 1 alone\n",
        )
    )
    assert [claim.outcome for claim in free.structure.claims] == ["proved"] * 6
    assert free.structure.conservative and free.structure.autonomous
    assert not free.structure.variational  # no canonical (q, p) is what methods carry
    assert not any(free.structure.cyclic)
    top = compile_model(
        Source(
            "model.lag",
            "model top\nparam A = 1\nparam C = 0.5\nrotation R\nlet w = omega(R)\n"
            "kinetic A/2*(w.x^2 + w.y^2) + C/2*w.z^2\npotential (R*[0,0,1]).z\n"
            "conserve upright = (R*p_R).z\nconserve own = p_R.z\n",
        )
    )
    assert [claim.outcome for claim in top.structure.claims] == ["proved"] * 2
    assert top.structure.cyclic[:3] == (False, False, True)


def test_the_reference_of_states_is_not_needed():
    """The C of a rotation is that of its equations handed on as rates."""
    made = compile_model(Source("model.lag", HUNG))
    e, structure = as_rates(made.equations, made.structure, None)
    assert e.n_first_order == 7 and len(e.rates) == 9
    assert lower(e, structure).equations.momenta_names[2].name == "p_R.x"
    assert analyze(made.equations).conservative is False


def test_a_state_in_the_energy_is_seen_where_the_attitude_is_gone():
    """The first of the states is a quaternion's number only while there is one."""
    text = case("leaking")
    use = Needing(columns=frozenset({"x", "omega(R).x"}))
    made = compile_model(Source("model.lag", text), use=use)
    assert made.equations.attitudes and not made.equations.quaternions
    assert not made.structure.conservative


PAIR = case("attitudes_pair")


@pytest.mark.parametrize(
    ("more", "columns", "left"),
    [
        ("", {"omega(A).x", "omega(B).x"}, 0),
        ("", {"A.w", "omega(B).x"}, 8),  # all rotations have their attitudes, or none
        ("", {"A.w"}, 4),
        ("constraint c: x = y\n", {"omega(A).x", "x"}, 4),  # steps return all to unit length
    ],
)
def test_the_quaternions_that_are_left(more, columns, left):
    use = Needing(columns=frozenset(columns))
    made = compile_model(Source("model.lag", PAIR + more), use=use)
    assert made.equations.quaternions == left
