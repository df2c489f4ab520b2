"""Predictions: at which step something happens, from an equilibrium's modes and a method's map."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ...record import record
from .ask import Equilibrium, Mode, Rest
from .method import PAIRS, StepMap, first_change
from .orbits import ROUNDED, closed

SAME = 0.1  # relative: a scale this near to a sharp limit adds nothing to it
TURNS = 2.1 * math.pi  # of the fastest mode, up to which the limit of impulses is sought
LOOKS = 4000  # on the way: steps grow where forces are nearly in tune alone
# Equilibria elsewhere that are told of; modes, the fastest, and pairs, the nearest to 1:2, of which
# resonances are.
MOST = 4
# Turns of so many steps. The last two are of methods that turn by more than half a turn a step.
RESONANCES = {
    "1:3": 2 * math.pi / 3,
    "1:4": 2 * math.pi / 4,
    "2:3": 4 * math.pi / 3,
    "3:4": 6 * math.pi / 4,
}


@record
class Prediction:
    """At step h a `kind` of thing happens near an equilibrium, by its modes, or to the motion.

    `kind` is limit, branch, local, or one of RESONANCES or PAIRS; `mode` numbers the mode whose
    y = h |lambda| it is (of a pair the faster), `other` the slower of a pair. h is None where it
    never happens. A scale, which is not `sharp`, is met within a factor of 2."""

    kind: str
    method: str
    equilibrium: int | None  # None: the motion itself
    mode: int | None
    other: int | None
    h: float | None
    y: float | None
    sharp: bool = True
    known: tuple[float | None, str] | None = None  # where it happened and how, if that was measured


def limit(step: StepMap, number: int, at: Equilibrium) -> Prediction | None:
    """The smallest of the limits of the modes; None where none oscillates or decays."""
    name, found = step.traits.name, []
    for k, mode in enumerate(at.modes):
        if mode.rate == 0 or mode.growth > 0:
            continue
        y = step.limit(-mode.growth / mode.rate)
        h = None if y is None else y / mode.rate
        found.append(Prediction("limit", name, number, k, None, h, y))
    return min(found, key=lambda p: math.inf if p.h is None else p.h, default=None)


def resonances(step: StepMap, number: int, at: Equilibrium) -> list[Prediction]:
    """RESONANCES of each mode, PAIRS of two, below the limit of the fastest."""
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
    """The limit of a method whose inner steps take a part of the forces, which is in no spring: the
    first step whose own linear map at the equilibrium has a multiplier outside of the unit circle.
    """
    if not at.stable or not at.oscillating:
        return None
    mode = at.oscillating[0]
    omega, here = at.modes[mode].frequency, step.asker.at(at)

    def grows(y: float) -> bool:
        question = {"method": step.traits.name, "h": y / omega, "count": 1}
        found = closed(here, state=(*at.q, *at.v), **question)
        return not found or found[0].growth > 1 + ROUNDED

    y = first_change(grows, 0.0, TURNS, LOOKS, close=1e-9)
    h = None if y is None else y / omega
    return Prediction("limit", step.traits.name, number, mode, None, h, y)


def branch(step: StepMap, number: int, at: Equilibrium) -> Prediction | None:
    """Where the equations of an implicit step lose their solution, by the fastest growth."""
    pole = step.pole() if step.traits.implicit else None
    real = [k for k, m in enumerate(at.modes) if m.growth > 0 and m.frequency == 0]
    if pole is None or not real:
        return None
    k = max(real, key=lambda k: at.modes[k].growth)
    return Prediction("branch", step.traits.name, number, k, None, pole / at.modes[k].growth, pole)


def local(step: StepMap, rates: Iterable[Mode]) -> Prediction | None:
    """Of the fastest that the equations linearised along the motion do, the shortest limit: a step
    beyond it does not resolve the motion where it is fastest. What grows there counts as what
    oscillates as fast; E. Hairer, S. P. Norsett, G. Wanner, Solving ODE I, I.10 (the logarithmic
    norm), II, IV.2. Of implicit methods without a limit it is the pole, but for
    first-order variables, which pass it where nothing grows for long. None of methods without
    either, or that grow at any step. Of what is bound, whose energy does not tell, it is measured
    whether some steps resolve the motion, and predicted is that: StepMap.resolves()."""
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
    """The limits at all stable equilibria, resonances at the one about which the motion is (none of
    linear models, which nothing detunes or pushes, nor of first-order variables and of what is
    bound, which turn in no plane of their own), branches at
    the unstable ones; of equilibria with the same modes, mirror images, at one, and of those that
    the motion is not about where steps are shortest: a chain has any number. Then the scale of the
    motion's `rates`.
    """
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
    """A small motion's scale is the limit of the equilibrium it is about."""
    return bool(p.kind == "limit" and p.h and along.h and abs(along.h / p.h - 1) < SAME)
