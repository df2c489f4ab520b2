"""SciPy: a loop of the user's from one terminal event to the next."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from ..scipy_ import VERSION, settings  # noqa: F401
from .cases import LESS, MU, OVER, SPEED, TIMES


def event(g, direction=-1):
    g.terminal, g.direction = True, direction
    return g


def ball():
    floor = event(lambda t, y: y[0])
    return [0, 5], lambda t, y: [y[1], -9.81], [floor], lambda y, i: [0, -0.8 * y[1]]


def cradle():
    def f(t, y):
        return [*y[5:], *(-9.81 / 0.3 * y[:5])]

    def hit(y, i):
        y = y.copy()
        y[5 + i], y[6 + i] = y[6 + i], y[5 + i]
        return y

    hits = [event(lambda t, y, i=i: y[i + 1] - y[i] + 1e-6) for i in range(4)]
    return [-0.1, *[0] * 9], f, hits, hit


def rock():
    kept, edge = 1 - 1.5 * np.sin(0.2) ** 2, event(lambda t, y: y[0])

    def f(t, y):
        return [y[1], edge.direction * 0.75 * 9.81 * np.sin(0.2 - abs(y[0]))]

    def hit(y, i):
        edge.direction = -np.sign(y[1])  # else a start at 0 is found again
        return [0, kept * y[1]]

    return [0.1, 0], f, [edge], hit


def graze(stop):
    wall = event(lambda t, y: stop - y[0])
    return [0, 1], lambda t, y: [y[1], -y[0]], [wall], lambda y, i: [stop, -0.5 * y[1]]


def from_hit_to_hit(model, times, settings, rest=0.0):
    y, f, events, after = model
    t, end, rests = 0, [], False
    for until in times:
        while t < until and not rests:
            r = solve_ivp(f, (t, until), y, events=events, **settings)
            t, y = r.t[-1], r.y[:, -1]
            if r.status == 1:
                y = after(y, next(i for i, x in enumerate(r.t_events) if len(x)))
                if abs(y[1]) < rest:  # else the loop stalls where bounces end
                    rests, y = True, [0, 0]
        end += [*y]
    return end


def box(settings, over):
    slope, stops = np.arctan(MU + over), event(lambda t, y: y[1])
    a = 9.81 * (np.sin(slope) - MU * np.cos(slope))
    y = [0, SPEED]
    return from_stick_to_slip(y, lambda t, y: [y[1], a], stops, None, 0, settings)


def belt(settings):
    breaks, meets = event(lambda t, y: y[0] - 1.5, 1), event(lambda t, y: y[1] - 0.1, 1)
    f = lambda t, y: [y[1], 1 - y[0]]  # noqa: E731
    return from_stick_to_slip([0, 0.1], f, meets, breaks, 0.1, settings)


def from_stick_to_slip(y, f, sticks, breaks, speed, settings):
    t, stuck, end = 0, y[1] == speed, []
    for until in TIMES["box" if breaks is None else "belt"]:
        while t < until:
            held = lambda t, y: [speed, 0]  # noqa: E731
            r = solve_ivp(held if stuck else f, (t, until), y,
                          events=breaks if stuck else sticks, **settings)  # fmt: skip
            t, y = r.t[-1], r.y[:, -1]
            if r.status == 1:
                stuck = not stuck
                y = [y[0], speed]
        end += [*y]
    return end


def _hits(model, *given, rest=0.0, short=np.inf):
    def prepare(way: str):
        times = TIMES[model.__name__]
        how = settings(way) | ({"max_step": short} if way == "best" else {})
        run = lambda x: from_hit_to_hit(model(*x), times, how, rest)  # noqa: E731
        return lambda: [n for x in given or [()] for n in run(x)]

    return prepare


def _sticks(model, *given):
    runs = given or [()]
    return lambda way: lambda: [n for x in runs for n in model(settings(way), *x)]


LOOP = "terminal event, own loop"
CASES = {
    "ball": (
        _hits(ball, rest=1e-9),
        (event, ball, from_hit_to_hit),
        LOOP,
        "bounces for ever; own rule of rest",
    ),
    "cradle": (_hits(cradle), (event, cradle, from_hit_to_hit), LOOP, "one by one, by own rule"),
    "rock": (_hits(rock, rest=1e-9), (event, rock, from_hit_to_hit), LOOP, "own rule of rest"),
    "box": (
        _sticks(box, [-OVER], [OVER]),
        (event, box, from_stick_to_slip),
        LOOP,
        "own rule of stick",
    ),
    "belt": (_sticks(belt), (event, belt, from_stick_to_slip), LOOP, "own rule of stick"),
    "graze": (
        _hits(graze, [1 - LESS], [1 + LESS], short=1e-3),
        (event, graze, from_hit_to_hit),
        LOOP,
        "passed silently / steps of 1 ms",
    ),
}
