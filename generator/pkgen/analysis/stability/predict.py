"""Predicts the step sizes at which a method fails or has a resonance. The predictions follow from
the modes of an equilibrium and from the method's step on the linear oscillator (method.py)."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ...record import record
from ..linear.rest import Equilibrium, Mode, Rest
from .method import PAIRS, StepMap, first_change
from .orbits import ROUNDED

SAME = 0.1  # an estimate within this relative distance of a sharp limit is omitted
TURNS = 2.1 * math.pi  # impulses() searches a limit up to this y of the fastest mode
LOOKS = 4000  # number of values of y that impulses() tries: it may grow in narrow intervals only
# MOST bounds the number of non-primary equilibria with predictions, of modes (the fastest), and of
# pairs of modes (with frequencies nearest to 1:2) with predicted resonances.
MOST = 4
# Rotation angle per step at each resonance. The last two are for methods that rotate by more than
# pi per step.
RESONANCES = {
    "1:3": 2 * math.pi / 3,
    "1:4": 2 * math.pi / 4,
    "2:3": 4 * math.pi / 3,
    "3:4": 6 * math.pi / 4,
}


@record
class Prediction:
    """An event of a `kind` at step size h, near an equilibrium or along the motion.

    `kind` is "limit", "branch", "local", "cycle", or a key of RESONANCES or PAIRS. `mode` is the
    index of the mode or, for a pair of modes, of the faster one; y is h |lambda| of this mode.
    `other` is the index of the slower mode of a pair. h is None if the event never happens. If
    `sharp` is false, h is an estimate that may be wrong by a factor of 2."""

    kind: str
    method: str
    equilibrium: int | None  # index; None for an event along the motion
    mode: int | None
    other: int | None
    h: float | None
    y: float | None
    sharp: bool = True
    known: tuple[float | None, str] | None = None  # h as measured, with a description


def limit(step: StepMap, number: int, at: Equilibrium) -> Prediction | None:
    """Returns the smallest stability limit of the modes; None if no mode oscillates or decays."""
    name, found = step.traits.name, []
    for k, mode in enumerate(at.modes):
        if mode.rate == 0 or mode.growth > 0:
            continue
        y = step.limit(-mode.growth / mode.rate)
        h = None if y is None else y / mode.rate
        found.append(Prediction("limit", name, number, k, None, h, y))
    return min(found, key=lambda p: math.inf if p.h is None else p.h, default=None)


def resonances(step: StepMap, number: int, at: Equilibrium) -> list[Prediction]:
    """Returns the predicted RESONANCES of single modes and of PAIRS of modes, as far as their step
    sizes are below the stability limit."""
    found, name = [], step.traits.name
    free = [k for k in at.oscillating if at.modes[k].growth == 0]
    bound = limit(step, number, at)
    most = math.inf if bound is None or bound.h is None else bound.h
    for k in free[:MOST]:
        omega = at.modes[k].frequency
        for kind, angle in RESONANCES.items():
            y = step.resonance(angle)
            if y is not None and y / omega < most:
                found.append(Prediction(kind, name, number, k, None, y / omega, y))
    pairs = [
        (fast, slow)
        for fast in free
        for slow in free
        if at.modes[fast].frequency > at.modes[slow].frequency * (1 + 1e-9)
    ]
    pairs.sort(key=lambda p: abs(at.modes[p[0]].frequency / at.modes[p[1]].frequency - 2))
    for fast, slow in pairs[:MOST]:
        omega = at.modes[fast].frequency
        for kind in PAIRS:
            y = step.pair(kind, omega / at.modes[slow].frequency)
            if y is not None and y / omega < most:
                found.append(Prediction(kind, name, number, fast, slow, y / omega, y))
    return found


def impulses(step: StepMap, number: int, at: Equilibrium) -> Prediction | None:
    """Returns the stability limit of a method that integrates fast forces with inner steps. Steps
    on a single oscillator do not show this limit. It is the first step size at which the method's
    step, linearised at the equilibrium, has an eigenvalue outside the unit circle."""
    if not at.stable or not at.oscillating:
        return None
    mode = at.oscillating[0]
    omega, here = at.modes[mode].frequency, step.asker.at(at)

    def grows(y: float) -> bool:
        question = {"method": step.traits.name, "h": y / omega, "count": 1}
        found = here.orbits(state=(*at.q, *at.v), **question)
        return not found or found[0].growth > 1 + ROUNDED

    y = first_change(grows, 0.0, TURNS, LOOKS, close=1e-9)
    h = None if y is None else y / omega
    return Prediction("limit", step.traits.name, number, mode, None, h, y)


def branch(step: StepMap, number: int, at: Equilibrium) -> Prediction | None:
    """Returns the step size at which the equations of an implicit step have no solution near an
    unstable equilibrium. It follows from the mode that grows fastest without oscillation."""
    pole = step.pole() if step.traits.implicit else None
    real = [k for k, m in enumerate(at.modes) if m.growth > 0 and m.frequency == 0]
    if pole is None or not real:
        return None
    k = max(real, key=lambda k: at.modes[k].growth)
    return Prediction("branch", step.traits.name, number, k, None, pole / at.modes[k].growth, pole)


def local(step: StepMap, rates: Iterable[Mode]) -> Prediction | None:
    """Returns the shortest stability limit for the eigenvalues `rates` along the motion: a longer
    step does not resolve the motion where it is fastest. A growing mode counts as an oscillation of
    equal rate (E. Hairer, S. P. Norsett, G. Wanner, Solving ODE I, I.10, on the logarithmic norm;
    II, IV.2). For an implicit method without a stability limit, the pole of StepMap.pole() is used
    instead. An exception are models with first-order variables: their steps pass the pole where
    growth is brief. If the model has rotations or constraints, the energy does not show errors, and
    StepMap.resolves() is used. Returns None if a method has none of these limits, or grows at any
    step size."""
    best: tuple[float, float] | None = None
    for mode in rates:
        if (mode.on_group and "group" not in step.traits.flags) or (
            mode.frequency > 0 and step.limit(0.0) == 0
        ):
            continue
        ratio = round(-mode.growth / mode.rate, 2)
        if step.bound and ratio <= 0 and not mode.on_group:
            y = step.resolves(-ratio > math.sqrt(0.5))
        else:
            y = step.limit(max(0.0, ratio))
        if y is None and (ratio < 0 or mode.on_group) and not step.states:
            y = step.pole()
        if y and (best is None or y / mode.rate < best[0]):
            best = y / mode.rate, y
    if best is None:
        return None
    return Prediction("local", step.traits.name, None, None, None, *best, sharp=False)


def predictions(
    step: StepMap, rest: Rest, primary: int | None, rates: Iterable[Mode] = ()
) -> list[Prediction]:
    """Returns an estimate from `rates` along the motion, then limits at stable equilibria, branches
    at unstable equilibria, and resonances at the primary equilibrium.

    Linear models have no resonances, since nothing couples modes or shifts frequencies. Models with
    first-order variables, rotations or constraints have none, since their modes are no planar
    oscillators. If several equilibria have equal modes (mirror images), only one has predictions.
    At most MOST non-primary equilibria have predictions, those with the shortest steps."""
    split = "fast" in step.traits.requires
    found: list[Prediction] = []
    seen: set[tuple[str, str]] = set()
    order = sorted(range(len(rest.equilibria)), key=lambda k: k != primary)
    for number in order if step.tells else ():
        at = rest.equilibria[number]
        one = (impulses if split else limit if at.stable else branch)(step, number, at)
        if one is None:
            continue
        rate = at.modes[one.mode].rate
        if (one.kind, f"{rate:.9g}") not in seen:
            seen.add((one.kind, f"{rate:.9g}"))
            found.append(one)
        planar = not (step.states or step.bound or split)
        if number == primary and at.stable and planar and not step.linear:
            found += resonances(step, number, at)
    elsewhere = [p for p in found if p.equilibrium != primary]
    least = sorted(elsewhere, key=lambda p: math.inf if p.h is None else p.h)[:MOST]
    found = [p for p in found if p.equilibrium == primary or p in least]
    along = None if split else local(step, rates)
    if along and not any(_says(p, along) for p in found if p.equilibrium == primary):
        found.insert(0, along)
    return found


def _says(p: Prediction, along: Prediction) -> bool:
    """Whether the estimate `along` the motion is nearly equal to the stability limit `p` of an
    equilibrium, so that it says nothing new."""
    return bool(p.kind == "limit" and p.h and along.h and abs(along.h / p.h - 1) < SAME)
