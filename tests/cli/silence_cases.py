"""What a run must never pass over in silence: each case with a model that provokes it.

The table in docs/dev/never-silent.md is made of these rows and of what pkgen says to each.
"""

from __future__ import annotations

from dataclasses import dataclass

from conftest import ROOT, case

DISK = """model disk
param k = 0.01
coord theta
kinetic theta'^2/2
potential -k^2/(2*theta^2)
start theta = 0.2, theta' = -k/0.2
"""
BELT = """model belt
coord x, y
kinetic (x'^2 + y'^2)/2 + 0.3*x'*y'
rolling driven: x' = 5*step(y - 1)
start y' = 1
"""
CREEP = """model creep
coord x
kinetic x'^2/2
potential x
dissipation x'^2/(2*(1 - t)^2)
start x = 1
"""
KEPLER = """model kepler
param mu = 1 in (0, inf)
coord x, y
kinetic (x'^2 + y'^2)/2
potential -mu/norm([x, y, 0])
start x = 0.6, y = 0.8
"""
POLAR = """model polar
coord r, phi
kinetic (r'^2 + r^2*phi'^2)/2
potential 0
start r = 1, r' = -0.7
"""
TWISTED = """model twisted
param c = 2
coord x, y
kinetic x'^2/2 + c*x'*y' + y'^2/2
potential x^2 + y^2
start x = 0.3
"""
FOLDED = """model folded
param l = 1
coord x
kinetic (l - x)*x'^2/2
potential 0
start x = 0.3, x' = 0.4
"""
ROOT_OF_X = """model fall
coord x
kinetic x'^2/2
potential sqrt(x)
start x = 1
"""
CHAIN = """model chain
size N = 20
coord x[1..N]
kinetic sum(x[i]'^2/2, i = 1..N)
potential sum(-1/(x[i+1] - x[i]), i = 1..N-1)
start x[i = 1..N] = i
"""
FOLDED_CHAIN = """model folded_chain
size N = 20
coord x[1..N], y[1..N]
kinetic sum(x[i]'^2/2 + y[i]'^2/2 + x[i]'*y[i]'*cos(x[i]), i = 1..N)
potential 0
start x[i = 1..N] = 1.5, x[7]' = -0.7
"""
REMOVABLE = """model sinc
coord x
kinetic x'^2/2
potential -sin(x)/x
start x = 1
"""
ARC = """model arc
coord x
kinetic x'^2/2
potential -asin(x)
start x = 0.1
"""
CUT = """model cut
coord x
kinetic x'^2/2
potential -atan2(sin(x), cos(x))
start x' = 4
"""
BLOCK = case("block")
ROD = case("rod")
PINCHED = """model pinched
coord x, y, z
kinetic (x'^2 + y'^2 + z'^2)/2
constraint sphere: x^2 + y^2 + z^2 = 1
constraint plane: z = t
start x = 1, z' = 1, y' = 0.5
"""
BLOW_UP = """model away
param a = 1 in (0, inf)
coord x
kinetic x'^2/2
potential -a*exp(x)
start x = 0.1
"""
PENDULUM = """model pendulum
coord theta
kinetic theta'^2/2
potential -cos(theta)
start theta = 2.9
"""
WATCHED = PENDULUM.replace("pendulum", "watched") + "observe root = sqrt(theta)\n"
TOP = (ROOT / "models/heavy_top.lag").read_text(encoding="utf-8")
DOUBLE = (ROOT / "models/double_pendulum.lag").read_text(encoding="utf-8")


@dataclass(frozen=True)
class Case:
    """`status` "" where the motion itself is done; `members`: the text of an ensemble's file."""

    what: str
    model: str
    arguments: str
    status: str
    members: str = ""


CASES: dict[str, Case] = {
    "singular-time": Case(
        "singular time (Euler's disk), by an adaptive method",
        DISK,
        "--until 3",
        "PK_SINGULAR_TIME",
    ),
    "singular-time-fixed": Case(
        "the same by a fixed step, which would step over it",
        DISK,
        "--until 3 --method rk4 --step 0.0101",
        "PK_SINGULAR_TIME",
    ),
    "collision": Case(
        "collision along a skew line",
        KEPLER,
        "--until 3 --method dop853",
        "PK_SINGULAR_TIME",
    ),
    "collision-fixed": Case(
        "the same by a symplectic method",
        KEPLER,
        "--until 3 --method verlet --step 0.01",
        "PK_SINGULAR_TIME",
    ),
    "root": Case(
        "a root that leaves the real numbers",
        ROOT_OF_X,
        "--until 10",
        "PK_SINGULAR_TIME",
    ),
    "arc": Case(
        "the same of an asin, whose force is infinite at its end",
        ARC,
        "--until 10",
        "PK_SINGULAR_TIME",
    ),
    "cut": Case(
        "a potential that jumps, at the cut of an atan2",
        CUT,
        "--until 2",
        "PK_SINGULAR_TIME",
    ),
    "removable": Case(
        "a division by what vanishes, though the quotient has a limit there",
        REMOVABLE,
        "--until 10",
        "PK_SINGULAR_TIME",
    ),
    "step-too-long": Case(
        "a step over a singularity that the motion does not reach",
        TOP,
        "--until 50 --method rk4 --step 0.5",
        "PK_STEP_TOO_LONG",
    ),
    "sliding": Case(
        "rest under dry friction, where the equations have no solution",
        BLOCK,
        "--until 20",
        "PK_SLIDING",
    ),
    "pole": Case(
        "coordinate singularity, theta -> 0 of the top",
        TOP,
        "--until 3 --start psi'=0 --start phi'=0 --start theta'=-7",
        "PK_SINGULAR_COORDINATES",
    ),
    "pole-implicit": Case(
        "the same by an implicit step",
        TOP,
        "--until 3 --start psi'=0 --start phi'=0 --start theta'=-7 --method gauss4 --step 0.01",
        "PK_SINGULAR_COORDINATES",
    ),
    "centre": Case(
        "coordinate singularity, r -> 0",
        POLAR,
        "--until 3 --method rk4 --step 0.01",
        "PK_SINGULAR_COORDINATES",
    ),
    "fold": Case(
        "M that becomes singular on the way",
        FOLDED,
        "--until 10",
        "PK_SINGULAR_COORDINATES",
    ),
    "chain": Case(
        "a family kept as loops, whose steps would be fused: two pairs collide at once",
        CHAIN,
        "--until 3 --every 0.4 --method verlet --step 0.01",
        "PK_SINGULAR_TIME",
    ),
    "chain-fold": Case(
        "M of a family kept as loops that becomes singular on the way, and regular again",
        FOLDED_CHAIN,
        "--until 3 --method rk4 --step 0.02",
        "PK_SINGULAR_COORDINATES",
    ),
    "indefinite": Case(
        "M that is indefinite, with the coordinate and the condition",
        TWISTED,
        "--until 1",
        "PK_SINGULAR_MASS",
    ),
    "newton": Case(
        "fixed-point iteration of an implicit step that does not contract",
        PENDULUM,
        "--until 20 --method gauss2 --step 5 --iteration fixed",
        "PK_NO_CONVERGENCE",
    ),
    "ambiguous": Case(
        "an implicit step whose equations have seven solutions (h omega = 6)",
        PENDULUM,
        "--until 12 --method gauss1 --step 6 --start theta=3.141592653589793",
        "PK_AMBIGUOUS_STEP",
    ),
    "underflow": Case(
        "motion that runs away in finite time: step underflow",
        BLOW_UP,
        "--until 10 --method dop853 --rtol 1e-6",
        "PK_STEP_UNDERFLOW",
    ),
    "not-finite": Case(
        "the same by a fixed step: not finite",
        BLOW_UP,
        "--until 10 --method rk4 --step 0.1",
        "PK_NOT_FINITE",
    ),
    "beyond": Case(
        "the same by fixed steps that arrive behind its end",
        BLOW_UP,
        "--until 2.2 --method rk4 --step 0.2",
        "RUN_BEYOND_END",
    ),
    "observed": Case(
        "an observed value that is no number, of a motion that is",
        WATCHED,
        "--until 9 --method dop853",
        "PK_DONE",
    ),
    "steps": Case(
        "more steps than allowed",
        PENDULUM,
        "--until 20 --method gauss2 --step 0.1 --max-steps 7",
        "PK_TOO_MANY_STEPS",
    ),
    "standstill": Case(
        "steps that shrink without an end, where the equations are ever stiffer",
        CREEP,
        "--until 3 --method dop853",
        "PK_NO_PROGRESS",
    ),
    "edge": Case(
        "an impulse that no motion follows: it throws back from the side that gives it",
        BELT,
        "--until 3",
        "PK_NO_IMPULSE",
    ),
    "refused": Case(
        "a method misused: M depends on q",
        DOUBLE,
        "--method verlet --step 0.01",
        "PK_REFUSED",
    ),
    "off-constraints": Case(
        "a start of options that breaks a constraint",
        ROD,
        "--until 1 --start x=1.25",
        "PK_OFF_CONSTRAINTS",
    ),
    "pinched": Case(
        "constraints that come to say the same",
        PINCHED,
        "--until 3 --method gauss",
        "PK_NO_PROJECTION",
    ),
    "off-the-rod": Case(
        "a step too long to return to the constraint",
        ROD,
        "--until 20 --method rk4 --step 1",
        "PK_NO_PROJECTION",
    ),
    "member": Case(
        "one member of an ensemble",
        KEPLER,
        "--until 1.5 --method rk4 --step 0.01",
        "",
        members="x,x',y,y'\n1,0,0,1\n0.6,0,0.8,0\n",
    ),
}

# What a run cannot provoke, since pkgen's driver sees to it; by programs of one's own.
IN_C = {
    "PK_BAD_ARGUMENT": ("tests/runtime/test_silence.c", "refused_options"),
    "PK_OUT_OF_BOUNDS": ("tests/runtime/test_silence.c", "parameters"),
    "PK_BLOCK_TOO_SMALL": ("tests/runtime/test_status.c", "bad_arguments"),
}
