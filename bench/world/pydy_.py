"""PyDy: Kane's equations by SymPy, made into C by Cython; integrate() is SciPy's odeint.

Its own integrate() knows no events: where the best way has to stop, the generated right-hand side
goes to the loops of scipy_.py, which a user would write too. It wants a constant in each model.
"""

from __future__ import annotations

from importlib import metadata

import numpy as np
import sympy as sm
import sympy.physics.mechanics as me
from pydy.system import System
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from .cases import UNTIL, road
from .scipy_ import BEST, from_edge_to_edge, from_sample_to_sample, from_time_to_time, pid

VERSION = f"PyDy {metadata.version('pydy')}, SymPy {sm.__version__}"


def wind():
    hip, knee, u1, u2 = me.dynamicsymbols("hip knee u1 u2")
    N, c, w = me.ReferenceFrame("N"), *sm.symbols("c w")
    upper = N.orientnew("A", "Axis", (hip, -N.y))
    lower = N.orientnew("B", "Axis", (hip + knee, -N.y))
    upper.set_ang_vel(N, -u1 * N.y)
    lower.set_ang_vel(N, -(u1 + u2) * N.y)
    o = me.Point("O")
    o.set_vel(N, 0)
    a, end = o.locatenew("a", -0.5 * upper.z), o.locatenew("end", -upper.z)
    b, tip = end.locatenew("b", -0.4 * lower.z), end.locatenew("tip", -0.8 * lower.z)
    for p, base, f in ((a, o, upper), (end, o, upper), (b, end, lower), (tip, end, lower)):
        p.v2pt_theory(base, N, f)
    one = me.RigidBody("one", a, upper, 1, (me.inertia(upper, 0.09, 0.09, 0.01), a))
    two = me.RigidBody("two", b, lower, 0.5, (me.inertia(lower, 0.03, 0.03, 0.005), b))
    loads = [(a, -9.81 * N.z), (b, -0.5 * 9.81 * N.z), (tip, c * (w * N.x - tip.vel(N)))]
    kane = me.KanesMethod(N, [hip, knee], [u1, u2], [hip.diff() - u1, knee.diff() - u2])
    kane.kanes_equations([one, two], loads)
    return kane, {c: 0.2, w: 4}, {hip: 1.2, knee: -0.5, u1: 0, u2: 0}, {}


def springs():
    x, v, k = me.dynamicsymbols("x v k")
    m = sm.Symbol("m")
    N, o, P = me.ReferenceFrame("N"), me.Point("O"), me.Point("P")
    o.set_vel(N, 0)
    P.set_vel(N, v * N.x)
    kane = me.KanesMethod(N, [x], [v], [x.diff() - v])
    kane.kanes_equations([me.Particle("P", P, m)], [(P, -k * x * N.x)])
    return kane, {m: 1}, {x: 0.3, v: 0}, {k: lambda y, t: 4 if y[0] > 0 else 25}


def car():
    z, w, dz, dw, h = me.dynamicsymbols("z w dz dw h")
    M, m, K, C, k = sm.symbols("M m K C k")
    N, P, Q = me.ReferenceFrame("N"), me.Point("P"), me.Point("Q")
    P.set_vel(N, dz * N.z)
    Q.set_vel(N, dw * N.z)
    inner = K * (z - w) + C * (dz - dw)
    kane = me.KanesMethod(N, [z, w], [dz, dw], [z.diff() - dz, w.diff() - dw])
    loads = [(P, -inner * N.z), (Q, (inner - k * (w - h)) * N.z)]
    kane.kanes_equations([me.Particle("P", P, M), me.Particle("Q", Q, m)], loads)
    height = CubicSpline(*road())
    constants = {M: 300, m: 40, K: 20e3, C: 1500, k: 180e3}
    return kane, constants, {z: 0, w: 0, dz: 0, dw: 0}, {h: lambda y, t: height(15 * t)}


def arm():
    a, b, da, db, u1, u2 = me.dynamicsymbols("a b da db u1 u2")
    N, o, g = me.ReferenceFrame("N"), me.Point("O"), sm.Symbol("g")
    upper = N.orientnew("A", "Axis", (a, -N.y))
    lower = N.orientnew("B", "Axis", (a + b, -N.y))
    upper.set_ang_vel(N, -da * N.y)
    lower.set_ang_vel(N, -(da + db) * N.y)
    o.set_vel(N, 0)
    P = o.locatenew("P", -0.5 * upper.z)
    Q = P.locatenew("Q", -0.4 * lower.z)
    P.v2pt_theory(o, N, upper)
    Q.v2pt_theory(P, N, lower)
    loads = [(P, -2 * g * N.z), (Q, -1.5 * g * N.z)]
    loads += [(upper, (u2 - u1) * N.y), (lower, -u2 * N.y)]
    kane = me.KanesMethod(N, [a, b], [da, db], [a.diff() - da, b.diff() - db])
    kane.kanes_equations([me.Particle("P", P, 2), me.Particle("Q", Q, 1.5)], loads)
    return kane, {g: 9.81}, {a: -0.5, b: 0.3, da: 0, db: 0}, {u1: 0, u2: 0}


def motors():
    N, o, n = me.ReferenceFrame("N"), me.Point("O"), sm.Symbol("n")
    o.set_vel(N, 0)

    def motor(name, u, J, R, K=0.3, b=0.01):
        phi, w = me.dynamicsymbols(f"phi_{name} w_{name}")
        frame = N.orientnew(name, "Axis", (phi, N.z))
        frame.set_ang_vel(N, w * N.z)
        body = me.RigidBody(name, o, frame, 1, (me.inertia(frame, 0, 0, J), o))
        return phi, w, body, (frame, (K * (u - K * w) / R - b * w) * N.z)

    p, v, left, f = motor("left", 12, 0.02, 1.5)
    q, w, right, g = motor("right", 0, 0.3, 4)
    kane = me.KanesMethod(
        N, [q], [w], [p.diff() - v, q.diff() - w], q_dependent=[p], u_dependent=[v],
        configuration_constraints=[p - n * q], velocity_constraints=[v - n * w],
    )  # fmt: skip
    kane.kanes_equations([left, right], [f, g])
    return kane, {n: 3}, {q: 0, p: 0, w: 1, v: 3}, {}


def by_edges(f, y, p):
    def edge(t, y, right):
        return y[0]

    edge.terminal = True
    held = lambda t, y, right: f(y, t, np.array([4.0 if right else 25.0]), p)  # noqa: E731
    return from_edge_to_edge(held, edge, y, UNTIL["springs"], BEST)


def by_knots(f, y, p, height):
    knots = [t for t in np.array(road()[0]) / 15 if t < UNTIL["road"] - 1e-9]
    held = lambda t, y: f(y, t, np.array([height(y, t)]), p)  # noqa: E731
    return from_time_to_time(held, y, [*knots, UNTIL["road"]], BEST)


def _case(name: str, build, means: str, kink: str = "–", *own) -> tuple:
    def prepare(way: str):
        kane, constants, start, specified = build()
        until = UNTIL[name]
        times = np.linspace(0, until, 1001)  # odeint gives up after 500 steps between two
        system = System(
            kane, constants=constants, initial_conditions=start, specifieds=specified, times=times
        )
        right_side = system.generate_ode_function(generator="cython")
        y = np.array([float(start[x]) for x in system.states])
        p = np.array([float(constants[x]) for x in system.constants_symbols])

        def f(*given):
            return right_side(*given).copy()  # which gives the same array each time

        def go():
            if name == "arm":
                settings = {} if way == "default" else BEST
                held = lambda t, y, u: f(y, t, u, p)  # noqa: E731
                end = from_sample_to_sample(held, y, pid(), 0.01, until, settings)
            elif way == "default":
                end = system.integrate()[-1]
            elif name == "springs":
                end = by_edges(f, y, p)
            elif name == "road":
                end = by_knots(f, y, p, *specified.values())
            else:
                end = solve_ivp(lambda t, y: f(y, t, p), (0, until), y, **BEST).y[:, -1]
            return [end[1], end[0], end[3], end[2]] if name == "motors" else end

        return go

    return prepare, (build, *own), means, kink


OWN = "own stops; else silent"
CASES = {
    "wind": _case("wind", wind, "frames, points, loads"),
    "springs": _case("springs", springs, "function of t", OWN, by_edges, from_edge_to_edge),
    "road": _case("road", car, "function of t", OWN, by_knots, from_time_to_time),
    "arm": _case("arm", arm, "own loop", "own stops", pid, from_sample_to_sample),
    "motors": _case("motors", motors, "function twice, constraint"),
}
