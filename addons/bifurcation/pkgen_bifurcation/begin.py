"""First periodic orbits: from the motion of the start, or small ones about an equilibrium."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy

from pkgen.analysis.linear.equilibria import TRIES, of_system
from pkgen.analysis.linear.system import EXACT, System
from pkgen.run import named
from pkgen.run.values import Values
from pkgen.system.exits import UsageError

from .family import Family
from .flow import Flow
from .orbits import TURN, Orbits
from .polynomials import LEAST_INTERVALS, MOST_INTERVALS, points
from .problem import Node, Path, Seed

LATER_STEPS = (500, 5000)  # steps after which a motion with friction may be near an orbit
RETURN_STEPS = 4000  # steps among which a return is looked for
RETURN_NEAR = 0.2  # distance of a return, in units of the motion's extent
POINTS_A_STEP = 40  # points of a step at which a return is looked for
AMPLITUDE = 1e-2  # size of a first small orbit, in units of the box
CENTRE_GROWTH = 1e-7  # growth of an oscillation, relative to its frequency, that counts as 0
NONE_FOUND = "no periodic orbit was found near the start; --period has about its period"


def _period(family: Family, text: str | None) -> float | Callable[[float], float] | None:
    """Returns --period: a number, or a function of the parameter. Raises UsageError."""
    known = named.parameters(family.compilation)
    if text is not None and text in known:
        index = known[text][0]
        return lambda value: float(family.system(value).given["parameters"][index])
    values = Values(family.compilation)
    return values.positive("--period", text, values.time)


def _checked(flow: Flow, of: float | Callable[[float], float] | None) -> Callable[[float], float]:
    """Returns the period of the forcing as a function of the parameter. Raises UsageError."""
    if of is None:
        raise UsageError("the equations depend on time: --period has the period of their forcing")
    whole = of if callable(of) else lambda value: of
    low, high = flow.family.range
    by = numpy.sin(numpy.outer([1, 2, 3], numpy.arange(1, flow.count + 1)))
    for value in (low, high):
        system, T = flow.family.system(value), whole(value)
        z = system.begun[flow.where] + 0.3 * by * (1 + abs(system.begun[flow.where]))
        t = numpy.array([0.113, 0.371, 0.829]) * T
        a, b = (flow.rates(system, x, z) for x in (t, t + T))
        if not (abs(a - b) <= 1e-9 * abs(a).max(1, initial=0.0)[:, None]).all():
            raise UsageError(
                f"at {flow.family.title} = {value:g} the equations do not have the period {T:g}: "
                "--period may be a parameter, as of 'param T = 2*pi/omega'"
            )
    return whole


def _motion(flow: Flow, system: System, state: numpy.ndarray, until: float):
    """Returns times, states and rates of the motion, a row a step."""
    it = system.begin(EXACT, state, rtol=1e-9)
    rows = it.steps(until, RETURN_STEPS)
    if it.failed:
        raise UsageError(f"the motion ends at t = {it.t:g} ({it.status}): no orbit begins there")
    t, z = numpy.append(0.0, rows[:, 0]), numpy.concatenate([state[None], rows[:, 1:]])
    z = z[:, flow.where]
    return t, z, flow.rates(system, t if flow.forced else 0 * t, z)


def _return(flow: Flow, system: System, state: numpy.ndarray) -> float | None:
    """Returns the time at which the motion first comes back to about its start, or None."""
    from scipy.interpolate import CubicHermiteSpline

    t, z, rates = _motion(flow, system, state, 1e300)
    for count in (50, 100, 200, 400, 800, 1600, len(t)):  # later the motion may be far away
        t1, z1, rates1 = t[:count], z[:count], rates[:count]
        of_step = numpy.linspace(0, len(t1) - 1, POINTS_A_STEP * len(t1))
        fine = numpy.interp(of_step, numpy.arange(len(t1)), t1)
        along = CubicHermiteSpline(t1, z1, rates1)(fine)
        scale = numpy.ptp(along, axis=0)
        used = scale > 0
        away = (along - along[0])[:, used]
        turns = ((flow.among < system.m) & (scale > TURN - 1))[used]
        away -= turns * TURN * numpy.round(away / TURN)
        units = numpy.where(turns, numpy.fmin(scale[used], TURN), scale[used])
        far = numpy.linalg.norm(away / units, axis=1)
        first = int((far > 0.5 * far.max(initial=0.0)).argmax())
        if not used.any():
            raise UsageError("the start is at rest: no orbit begins there")
        least = (far[1:-1] < far[:-2]) & (far[1:-1] <= far[2:]) & (far[1:-1] < RETURN_NEAR)
        near = 1 + numpy.flatnonzero(least)
        near = near[near > first]
        if near.size:
            return float(fine[near[0]])
    return None


def _states(system: System, later: Sequence[int], period: float | None) -> Iterator:
    """Yields the start, and states after so many steps or more, at multiples of the forcing's
    period, until the motion ends."""
    state = system.begun
    yield state
    for steps in later:
        it = system.begin(EXACT, state, rtol=1e-9)
        it.steps(1e300, steps)
        if period:
            it.to(math.ceil(it.t / period) * period)
        if it.failed:
            return
        state = it.state
        yield state


def from_start(family: Family, text: str | None) -> list[Seed]:
    """Returns the orbit near the start. Raises UsageError."""
    flow = Flow(family)
    value = family.range[0] if family.name is None else family.own()
    made = _forced_start if flow.forced else _free_start
    problem, seed = made(flow, _period(family, text), value)
    low, high = family.range
    if not low <= seed.value <= high:
        raise UsageError(
            f"--free {family.title}: the orbit at the start has {seed.value:.10g}, "
            "which FROM:TO is to contain"
        )
    return [Seed(problem, seed)]


def _forced_start(flow: Flow, period, value: float) -> tuple[Orbits, Node]:
    """Returns an orbit with the period of the forcing. Raises UsageError."""
    period, system = _checked(flow, period), flow.family.system(value)
    T = period(value)
    for state in _states(system, LATER_STEPS, T):
        if found := _orbit(flow, state, period, T, value):
            return found
    raise UsageError(NONE_FOUND)


def _free_start(flow: Flow, period, value: float) -> tuple[Orbits, Node]:
    """Returns an orbit whose period is not known. Raises UsageError."""
    system, all_return = flow.family.system(value), True
    guess = period(value) if callable(period) else period
    for state in _states(system, () if flow.conservative else LATER_STEPS, None):
        T = guess or _return(flow, system, state)
        all_return &= T is not None
        if T and (found := _orbit(flow, state, T, T, value)):
            return found
    if all_return:
        raise UsageError(NONE_FOUND)
    raise UsageError("the motion does not come back to its start: --period has about its time")


def _orbit(flow: Flow, state, period, T: float, value: float) -> tuple[Orbits, Node] | None:
    """Returns the orbit near the motion from a state in the time T."""
    system = flow.family.system(value)
    times, _, _ = _motion(flow, system, state, T)
    if len(times) < 4 or times[-1] < T:
        return None
    # The steps of the motion are as long as its errors allow.
    count = min(MOST_INTERVALS, max(LEAST_INTERVALS, 2 * len(times)))
    of_step = numpy.linspace(0, len(times) - 1, count + 1)
    grid = numpy.interp(of_step, numpy.arange(len(times)), times / T)
    it, guess = system.begin(EXACT, state, rtol=1e-12), []
    for time in points(grid) * T:
        it.to(time)
        guess.append(it.state[flow.where])
    guess = numpy.array(guess)
    if it.failed:
        return None
    problem = Orbits(flow, grid, guess, period, value)
    if flow.conservative and not flow.forced and flow.family.name is not None:
        problem.energy0 = float(flow.energies(system, guess[:1])[0])
    x, row = problem.begun, numpy.zeros(len(problem.of))
    if flow.family.name is not None:
        row[-1] = 1.0
    found = problem.correct(x, row, float(row @ x[problem.of]))
    if found is None:
        return None
    x = found[0]
    along = numpy.zeros(len(x))
    along[problem.of] = row if flow.family.name is not None else problem.energy_row(x)
    tangent = problem.tangent(x, along)
    try:
        for _ in range(2):
            x, tangent = problem.adapted(x, tangent)
    except ArithmeticError:
        return None
    row = numpy.append(numpy.zeros(len(problem.of) - 1), row[-1:])
    last = (value - flow.family.range[0]) / flow.family.width
    found = problem.correct(x, row, last * row[-1])
    if found is None:
        return None
    seed = problem.node(found[0], problem.tangent(found[0], tangent))
    if seed is None or seed.about["period"] < 0.2 * T:
        return None
    problem.slack = problem.slack_at(seed)
    return problem, seed


def _units(flow: Flow, box: numpy.ndarray) -> numpy.ndarray:
    """Returns the box of the search; numbers that the motion of the start keeps are tiny in it."""
    wide = numpy.concatenate([box, box])[flow.where]
    return numpy.fmax(wide, 0.1 * wide.max(initial=0.0))


def small(family: Family, flow: Flow, system: System, state, value: float, width, which=None):
    """Returns small orbits about an equilibrium, one for each oscillation that does not grow."""
    z = state[flow.where]
    A = flow.jacobian(system, numpy.zeros(1), z[None])[0]
    values, shapes = numpy.linalg.eig(A)
    found = []
    for k in numpy.argsort(-values.imag):
        omega = values[k].imag
        if omega <= 0 or (which is None and abs(values[k].real) > CENTRE_GROWTH * omega):
            continue
        if which is not None and abs(values[k] - which) > 1e-4 * abs(which):
            continue
        units = numpy.where(flow.among >= system.n, width * omega, width)
        shape = shapes[:, k] / (abs(shapes[:, k] / units).max())
        grid = numpy.linspace(0, 1, LEAST_INTERVALS + 1)
        turn = numpy.exp(2j * numpy.pi * points(grid))[:, None]
        wave = (shape * turn).real
        problem = Orbits(flow, grid, z + AMPLITUDE * wave, 2 * numpy.pi / omega, value, units)
        to = problem._packed(wave[:-1], 0.0, family.range[0])
        row = to[problem.of] / numpy.linalg.norm(to[problem.of])
        at = problem.correct(problem.begun, row, float(row @ problem.begun[problem.of]))
        seed = at and problem.node(at[0], problem.tangent(at[0], to))
        if seed:
            found.append((problem, seed))
    return found


def from_centre(family: Family) -> list[Seed]:
    """Returns small orbits about the equilibrium nearest to the start. Raises UsageError."""
    if family.name is not None:
        raise UsageError("--orbit centre is followed along --free energy=FROM:TO")
    flow, system = Flow(family), family.first
    if flow.forced:
        raise UsageError("the equations depend on time, and nothing rests: --orbit start")
    rest = of_system(system, family.compilation, TRIES)
    if not rest.equilibria:
        raise UsageError("no equilibrium was found: --start is to be nearer to one")
    at = rest.nearest(system.q(system.begun), system.v(system.begun))
    state = numpy.array([*at.q, *at.v])
    low, high = family.range
    if not low <= at.energy <= high:
        raise UsageError(
            f"--free energy: the equilibrium has {at.energy:.10g}, which FROM:TO is to contain"
        )
    found = small(family, flow, system, state, 0.0, _units(flow, numpy.array(rest.box)))
    if not found:
        raise UsageError("about the equilibrium nearest to the start no oscillation lasts")
    return [Seed(*one, outward=True) for one in found]


def from_hopf(family: Family, paths: list[Path]) -> list[Seed]:
    """Returns small orbits at the Hopf bifurcations of equilibria. Raises UsageError."""
    flow, found = Flow(family), []
    for path in paths:
        for node in path.specials:
            if node.kind != "hopf":
                continue
            system = family.system(node.value)
            z, _ = path.problem.parts(node.x)
            state = path.problem.steady(node.value).states(z)
            width = _units(flow, path.problem.search.box[: system.n])
            complex_ = node.values[node.values.imag > 0]
            which = complex_[abs(complex_.real).argmin()]
            for problem, seed in small(family, flow, system, state, node.value, width, which):
                found.append(Seed(problem, seed, _shrunk(node, seed, which.imag), True))
    if not found:
        raise UsageError("no Hopf bifurcation of an equilibrium was found in the range")
    return found


def _shrunk(node: Node, seed: Node, omega: float) -> Node:
    """Returns an equilibrium as an orbit."""
    extents = {name: (x, x) for name, x in node.about["state"].items()}
    about = {**node.about, "period": float(2 * numpy.pi / omega), "extents": extents}
    return replace(seed, value=node.value, about=about, kind=node.kind)
