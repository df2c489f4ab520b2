"""Impacts and friction: orders that are kept, walls of springs, grazes, laws that contradict.

CO1: steps end at located impacts. The pendulum's swing, reflected at its lowest point, is -|theta|.
CO2: a mass stays half a period of a spring, pi/sqrt(k), in it; two of them make a period longer.
CO3: Verlet keeps p^2 + (1 - h^2/4) q^2 (GNI I.1.4), so from p = 1 it reaches q = 1 with p = h/2,
where the motion only touches: a step's error of h^2 is one of h behind an impact.
CO4: of amplitude 1 + d an oscillator meets the wall at sqrt(2 d) (A. B. Nordmark, J. Sound Vib. 145
(1991) 279), and (1 + e) times it is its place at t = pi.
CO5: a jump of the plate's period T begins with g T/2, where the plate has the rate g T (1 - e)/(2
(1 + e)). Its map has the determinant e^2 and the trace 1 + e^2 + (1 + e)^2 a/g, a the plate's
acceleration there. It is -1 - e^2 for G^2 = (pi (1 - e)/(1 + e))^2 + 4 (1 + e^2)^2/(1 + e)^4 (P. J.
Holmes, J. Sound Vib. 84 (1982) 173). The first two jumps beside it give the trace.
CO6, CO7: tanh(v/eps) in place of friction creeps where it equals the push r, and its slope is
(1 - r^2)/eps there. `friction` holds: x stays 0.
CO8: the belt's pull grows from 2 F - S to S, the block slips round a circle about F/k.
CO9: a force N on the tip gives it N (1 + 3 c (c - mu s)), c and s of the lean, which is 0 for
mu = (1 + 3 c^2)/(3 c s), 4/3 at least (P. Painleve, C. R. Acad. Sci. 121 (1895) 112).
CO10: with [[a, b], [b, a]] the inverse mass of the tip, a = 1 + 3/2, b = -3/2, Newton's law and a
tip that sticks give (-(1 - e^2) a u^2 + 2 b u s - a s^2)/(2 (a^2 - b^2)), u = -1 and s the rates
before (after T. R. Kane, A dynamics puzzle, 1984).
CO11: one impact of all makes the first gap open at the rate at which it closed, and keeps the
others: of the rate the first ball has 2/5 - 1 then, each other one 2/5. One after the other, as
they are a millionth apart, they have 0, 0, 0, 0 and 1. It is said that they differ.
"""

from math import atan2, atanh, pi, sqrt

from .linear import axis_limit
from .prediction import BOUNDARY, CLOSED, ORDER
from .shown import around, shown

CREEP = "pkgen run creep.lag --method {} --until {} --every {}"
SLOPE = (1 - 0.5**2) / 1e-3
STABLE = axis_limit("rk4", -1) / SLOPE
TOUCH = "pkgen run touched_wall.lag --method {}"
CRADLE = "pkgen run ../../../models/contact/newton_cradle.lag --set gap=0 --method gauss"

PREDICTIONS = [
    shown(
        "CO1", "pendulum that a wall reflects, rk4", "keeps its order at impacts: the error goes "
        "with the power of h", 4.0, ORDER,
        "for h in 0.05 0.025 0.0125; do pkgen run walled_pendulum.lag --method rk4 --step $h "
        '--until 8 --every 8 --record "error(a)"; done',
        "power of h: abs(error_a_[-1])", "--method rk3",
    ),
    shown(
        "CO2", "mass between springs in place of walls, k = 1e4, gauss",
        "a period is 2, and 2 pi/sqrt(k) too long", 2 + 2 * pi / 100, 1e-9,
        "pkgen run soft_walls.lag --method gauss --until 10",
        'diff(times(report, "right"))[-1]', "--method verlet --step 0.01",
    ),
    shown(
        "CO3", "oscillator that touches a wall, verlet, h = .1", "strikes it: order 2 falls to 1, "
        "with the rate h/2", 0.05, CLOSED,
        f'{TOUCH.format("verlet")} --step 0.1 --until 2 --at hit --record "q\'"', "max(q')",
        "--method gauss",
    ),
    shown(
        "CO4", "oscillator that strikes a wall d below its amplitude, gauss",
        "the way behind it goes with the power of d", 0.5, 1e-3,
        f"for d in 1e-8 1e-6 1e-4; do {TOUCH.format('gauss')} --set up=1+$d --until pi --every pi; "
        "done", "power of d: abs(q[-1])", "--method rk4 --step 0.2",
    ),
    shown(
        "CO5", "ball on a shaken plate, e = .5, gauss", "jumps in turn high and low from G = "
        "A w^2/g on", sqrt((pi / 3) ** 2 + 4 * 1.25**2 / 1.5**4), BOUNDARY,
        "for G in 1.4 1.6; do pkgen run shaken_plate.lag --set G=$G --method gauss --until 2.5; "
        "done", 'root of G: (times(report, "hit")[1] - 2)/(times(report, "hit")[0] - 1) + 1.25',
        "--method euler --step 0.01",
    ),
    shown(
        "CO6", "block under half of a friction that is written as tanh(v/.001), gauss",
        "creeps at .001 atanh(1/2), where friction holds", 1e-3 * atanh(0.5), 1e-9,
        CREEP.format("gauss", 10, 10), "x'[-1]", "--method rk4 --step 0.004",
    ),
    shown(
        "CO7", "block under half of a friction that is written as tanh(v/.001), rk4",
        "chatters from h = 2.785/750 on, for its slope", STABLE, BOUNDARY,
        f"for h in {around(STABLE)}; do {CREEP.format('rk4', '5000*$h', '5000*$h')} --step $h "
        "--start \"x'=0.00055\"; done", f"edge of h: abs(x'[-1] - {1e-3 * atanh(0.5)!r}) > 1e-8",
        "--method rk3",
    ),
    shown(
        "CO8", "block on a belt, F = 1, S = 1.5, gauss", "sticks and slips with the period "
        "2 (S - F)/(k v) + 2 (pi - atan((S - F)/v))", 10 + 2 * (pi - atan2(0.5, 0.1)), 1e-9,
        "pkgen run ../../../models/contact/stick_slip_belt.lag --method gauss --until 60",
        'diff(times(report, "breaks"))[-1]', "--method rk2 --step 0.5",
    ),
    shown(
        "CO9", "rod that slides on its tip, tan(lean) = 2, gauss", "no motion, which is said, from "
        "mu = 4/3 on", 4 / 3, BOUNDARY,
        f"for mu in {around(4 / 3)}; do pkgen run sliding_rod.lag --set mu=$mu --method gauss "
        "--until 0.01; done", 'edge of mu: "no motion satisfies" in said',
        "--set begin=pi/4", no_method="the law's own, whatever the method: another lean",
    ),
    shown(
        "CO10", "rod whose end strikes a rough floor, e = .9, slip .2, gauss", "Newton's law and "
        "friction gain energy", (-0.19 * 2.5 + 2 * 1.5 * 0.2 - 2.5 * 0.04) / 8, 1e-9,
        "pkgen run thrown_rod.lag --method gauss --until 0.2 --every 0.2",
        "energy[-1] - energy[0]", "--set slip=0",
        no_method="the law's own, whatever the method: no slip",
    ),
    shown(
        "CO11", "cradle of five balls that touch, gauss", "one impact of all, as is said: rates of "
        "last and first", -2 / 3, 1e-9, f"{CRADLE} --until 0.3 --every 0.3",
        'x_5_\'[-1]/x_1_\'[-1] if "at once" in said else 0', "--set gap=1e-6",
        no_method="the law's own, whatever the method: balls apart",
    ),
]  # fmt: skip
