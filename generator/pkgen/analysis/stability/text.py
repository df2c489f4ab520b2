"""Writes the summary, and the tables that the HTML page shows too."""

from __future__ import annotations

import csv
import io
import math

from ...run import named
from ...system.columns import aligned
from ..linear.rest import Equilibrium, Mode
from .ask import TRIES
from .map import StabilityMap
from .misses import difference, misses, name_mode, unmeasured, unpredicted, unsought
from .predict import Prediction

MODES = 6  # most modes listed for each equilibrium
FAR = ("rise", "away", "exchange", "moved", "follows")  # fields of a Point that the CSV contains
Table = tuple[list[str], list[list[str]]]


def _unknowns(made: StabilityMap) -> list[tuple[str, bool]]:
    """Returns the name of each unknown of an equilibrium, and whether it is a rate."""
    places, rates = _names(made)
    moving = {k for k, cyclic in enumerate(made.compilation.structure.cyclic) if cyclic}
    moving |= {*range(len(places), len(rates))}
    return [(name if k in moving else places[k], k in moving) for k, name in enumerate(rates)]


def _names(made: StabilityMap) -> tuple[list[str], list[str]]:
    """Returns the names of the coordinates and of their rates."""
    found = (named.coordinates(made.compilation, rates=rates) for rates in (False, True))
    places, rates = ([c.name for c in one.columns(64)] for one in found)
    return places, rates


def _shown(made: StabilityMap) -> list[tuple[int, tuple[str, bool]]]:
    """Returns the elements of _unknowns() with their indices. Body rates are left out, since they
    are 0 at equilibria."""
    first = made.turned.start - 3 * len(made.turned) // 4
    still = range(first, made.turned.start)
    return [(i, one) for i, one in enumerate(_unknowns(made)) if i not in still]


def place(made: StabilityMap, at: Equilibrium) -> str:
    """Returns `theta1 = 0, theta2 = 3.14159`; a cyclic coordinate is given by its constant rate."""
    of_q = _sizes([made.motion.q, *(e.q for e in made.rest.equilibria)])
    of_v = _sizes([made.motion.v, *(e.v for e in made.rest.equilibria)])
    said = []
    for i, (name, by_rate) in _shown(made):
        x, size = (at.v[i], of_v[i]) if by_rate else (at.q[i], of_q[i])
        said.append(f"{name} = {_short(x, size)}")
    return ", ".join(said[:6]) + (", ..." if len(said) > 6 else "")


def _sizes(states: list[tuple[float, ...]]) -> list[float]:
    """Returns the largest magnitude of each number of the states. If a number is 0 in the first
    state, the largest magnitude of all numbers is returned for it."""
    whole = max((abs(x) for state in states for x in state), default=0.0)
    return [max(map(abs, column)) if column[0] else whole for column in zip(*states, strict=True)]


def _short(x: float, largest: float) -> str:
    """Formats x, or 0 if x is round-off relative to `largest`."""
    return f"{0.0 if abs(x) < 1e-12 * largest else x:.6g}"


def rate(mode: Mode) -> str:
    if mode.growth == 0 and mode.frequency == 0:
        return "neutral"
    if mode.frequency == 0:
        return f"{'grows' if mode.growth > 0 else 'decays'} at {abs(mode.growth):.10g}"
    said = f"omega = {mode.frequency:.10g}"
    return said if mode.growth == 0 else f"{said}, growth {mode.growth:+.6g}"


def equilibria(made: StabilityMap) -> Table:
    rows, by_norm = [], made.motion.by_norm
    energy = max((abs(e.energy) for e in (made.motion, *made.rest.equilibria)), default=0.0)
    for k, at in enumerate(made.rest.equilibria):
        mark = " (the motion's)" if k == made.primary else ""
        modes = [m for m in at.modes if not (m.growth < 0 and m.frequency == 0 and not at.stable)]
        said = "; ".join([*map(rate, modes[:MODES]), *(["..."] if len(modes) > MODES else [])])
        energy_of = [] if by_norm else [_short(at.energy, energy)]
        rows.append([f"{k + 1}{mark}", place(made, at), *energy_of, at.verdict, said])
    return ["", "equilibrium", *([] if by_norm else ["energy"]), "", "modes, fastest first"], rows


def predicted(made: StabilityMap) -> Table:
    """Returns the table of predictions and their measurements."""
    rows = []
    for m in made.measured:
        p = m.prediction
        off = difference(p.h, m.h)
        note = m.how if m.how != "turning" else "some steps beside it fail"
        if m.response is not None:
            answered = f"responds {m.response:.3g} times as much at h = {m.peak:.5g}"
            note = "nothing responds" if m.silent else answered
        at = "motion" if p.equilibrium is None else str(p.equilibrium + 1)
        digits = 7 if p.sharp else 3
        numbers = [_or_none(p.y, digits), _or_none(p.h, digits), _or_none(m.h, digits)]
        far = _off(off) if p.sharp else _times(p, m.h)
        rows.append([p.method, p.kind, at, name_mode(p), *numbers, far, note])
    heads = ["method", "what", "at", "of", "h omega", "predicted h", "measured h", "off", "note"]
    return heads, rows


def _or_none(x: float | None, digits: int) -> str:
    return "none" if x is None else f"{x:.{digits}g}"


def _off(off: float | None) -> str:
    return "MISSED" if off is None else f"{100 * off:+.1g} %"


def _times(p: Prediction, h: float | None) -> str:
    """Formats a measured step size as a multiple of the estimated step size."""
    return "MISSED" if h is None or not p.h else f"x {h / p.h:.2g}"


def rates(made: StabilityMap) -> Table:
    rows = []
    for g in made.growths:
        off = _off(difference(g.predicted, g.measured))
        both = f"{g.predicted:.10g}", f"{g.measured:.10g}"
        rows.append([str(g.equilibrium + 1), f"mode {g.mode + 1}", *both, off])
    return ["at", "of", "predicted rate", "measured", "off"], rows


def ghosts(made: StabilityMap) -> Table:
    """Returns the table of ghosts, spurious orbits of a method (ghosts.py). If a ghost was found at
    several step sizes, its row is for the middle one."""
    rows = []
    for g in made.ghosts:
        one = g.middle
        where = "; ".join(_state(made, y, one.states) for y in one.states)
        stays = {None: "repels", True: "a run stays there", False: "a run leaves in time"}[g.stays]
        steps = f"{g.orbits[0].h:.4g} .. {g.orbits[-1].h:.4g}"
        rows.append([g.method, g.kind, steps, f"{one.h:.5g}", where, f"{one.growth:.4g}", stays])
    return ["method", "what", "from h to", "at h", "where", "multiplier", ""], rows


def _state(made: StabilityMap, y: tuple[float, ...], beside: tuple[tuple[float, ...], ...]) -> str:
    """Formats the coordinates and rates of a state of a ghost, whose rates may differ from 0.
    Angles are in (-pi, pi]."""
    places, rates = _names(made)
    turns, cyclic = made.rest.turns, made.compilation.structure.cyclic
    largest = max(abs(x) for state in beside for x in state)
    said = []
    for i, name in enumerate(places):
        x = math.remainder(y[i], 2 * math.pi) if turns and turns[i] else y[i]
        x = abs(x) if turns and turns[i] and abs(x) > math.pi * (1 - 1e-9) else x
        said += [] if cyclic[i] else [f"{name} = {_short(x, largest)}"]
    moving = zip(rates, y[len(made.motion.q) :], strict=False)
    return ", ".join([*said, *(f"{name} = {_short(x, largest)}" for name, x in moving)])


def cycle(made: StabilityMap) -> str:
    """Returns a sentence on the limit cycle and its stability."""
    assert made.cycle
    unit = "" if made.compilation.model.dimensionless else " s"
    kind = "in step with what drives it, of period" if made.cycle.driven else "on a cycle of period"
    rest = abs(made.cycle.orbit.beyond(made.cycle.trivial))
    return (
        f"the motion is in the end {kind} {made.cycle.period:.8g}{unit}; what is beside it is "
        f"{rest:.4g} times as far after one"
    )


def counts(made: StabilityMap) -> Table:
    """Returns the table of the number of points per method and class."""
    from .classes import CLASSES

    kinds = [k for k in CLASSES if any(p.shown == k for row in made.rows for p in row.points)]
    rows = []
    for name in made.steps:
        points = [p for row in made.rows for p in row.points if p.method == name]
        rows.append([name, *(str(sum(p.shown == k for p in points)) for k in kinds)])
    return ["points", *kinds], rows


def searched(made: StabilityMap) -> str:
    """Describes the number of equilibria found, and the region searched."""
    rest, names, turned = made.rest, _shown(made), made.turned
    parts = []
    for i, (name, by_rate) in names[:6]:
        if i in turned:
            if (i - turned.start) % 4 == 0:
                parts.append(f"{name.rpartition('.')[0]} all around")
        elif rest.turns and rest.turns[i] and not by_rate:
            parts.append(f"{name} all around")
        else:
            low, high = rest.middle[i] - rest.box[i], rest.middle[i] + rest.box[i]
            parts.append(f"{name} from {low:.3g} to {high:.3g}")
    more = ", ..." if len(names) > 6 else ""
    return (
        f"equilibria: found {len(rest.equilibria)}, sought from {TRIES + 1} starts or more, "
        f"{', '.join(parts)}{more}, half of them up to 32 times as far"
    )


def remarks(made: StabilityMap) -> list[str]:
    """Returns sentences on everything that the map omits, with reasons."""
    found = [*([made.interrupted] if made.interrupted else []), *made.asked.left]
    rest = made.rest
    if rest.status == "PK_REFUSED":
        found.append(f"equilibria are not sought: {unsought(made)}")
    model = made.compilation.model
    bound = [
        s for s, of in (("rotations", model.rotations), ("constraints", model.constraints)) if of
    ]
    if bound:
        found.append(f"with {' and '.join(bound)} resonances, cycles and ghosts are not sought")
    going = [str(k + 1) for k, e in enumerate(rest.equilibria) if e.nullity]
    if going:
        many = len(going) > 1
        found.append(
            f"equilibri{'a' if many else 'um'} {', '.join(going)} {'are each' if many else 'is'} "
            "one of a continuum, along which nothing pulls back"
        )
    if any(made.compilation.structure.cyclic):
        found.append(
            "cyclic coordinates do not rest: equilibria are relative, at the momenta of the start"
        )
    if rest.singular:
        found.append(
            f"{rest.singular} starts led to where M is singular, the pole of the coordinates: "
            "whether the system can rest there they cannot tell"
        )
    if rest.equilibria:
        found.append(searched(made))
    if made.cycle:
        found.append(cycle(made))
    found += [
        f"{one.method} was followed along the cycle to h = {one.h:.4g}: {one.how}"
        for one in made.lost
        if not one.sharp
    ]
    if rest.more:
        flat = sum(any(mode.rate == 0 for mode in e.modes) for e in rest.equilibria)
        found.append(
            "equilibria form a continuum: along a mode of most of them nothing pulls back"
            if 2 * flat > len(rest.equilibria)
            else "there are more equilibria than are listed"
        )
    found += conditions(made)
    for does, says, rows in (
        ("ends", "{} at t = {:.6g}", [r for r in made.rows if r.motion.status != "PK_DONE"]),
        (
            "leaves",
            "at t = {1:.6g} it is still going away, so no method is judged there by whether it "
            "stays",
            [row for row in made.rows if row.motion.leaves],
        ),
    ):
        if rows:
            first = rows[0].motion
            found.append(
                f"the motion itself {does} in {len(rows)} of {len(made.rows)} rows, first at "
                f"{made.asked.axis.name} = {rows[0].x:.4g}: {says.format(first.status, first.t)}"
            )
    return found


def conditions(made: StabilityMap) -> list[str]:
    """Returns sentences on the largest condition numbers of motions and steps."""
    found = [row.motion.warning for row in made.rows if row.motion.warning][:1]
    looked = [(row, row.motion.condition) for row in made.rows if row.motion.condition]
    said = []
    for what, name in (("mass", "M"), ("constraints", "J M^-1 J^T")):
        if most := max(((c[what]["cond"] or math.inf) for _, c in looked if what in c), default=0):
            said.append(f"of {name} {most:.3g}")
    for name in made.steps:
        points = [p for row in made.rows for p in row.points if p.method == name]
        worst = max(points, key=lambda p: math.inf if p.cond is None else p.cond, default=None)
        if worst and worst.cond != 0:
            most = math.inf if worst.cond is None else worst.cond
            said.append(f"of the equations of a step of {name} {most:.3g} (h = {worst.h:.3g})")
    if said:
        found.append(f"condition numbers along the motions, at most: {', '.join(said)}")
    return found


def sentences(made: StabilityMap) -> list[str]:
    """Returns a sentence on each disagreement of prediction and measurement. If there are none,
    returns one sentence, which says so or says that nothing was predicted."""
    why = unpredicted(made)
    if why:
        return [f"nothing is predicted here: {why}"]
    found = [*(m.text for m in misses(made)), *unmeasured(made)]
    return found or ["none: measured is what was predicted"]


def tables(made: StabilityMap) -> list[tuple[str, str, Table]]:
    """Returns the nonempty tables: title, continuation of the title on the page, table."""
    found = [
        ("Predicted and measured", "", predicted(made)),
        ("Growth rates", " at unstable equilibria", rates(made)),
        ("Ghosts", " of the step map, which the equations do not have", ghosts(made)),
        ("Points", " of each class", counts(made)),
    ]
    return [row for row in found if row[2][1]]


def report(made: StabilityMap) -> str:
    name = made.compilation.model.name
    unit = "" if made.compilation.model.dimensionless else " s"
    out = [
        f"{name}: {len(made.rows)} values of {made.asked.axis.name}, "
        f"{made.asked.across} steps, {made.until:.6g}{unit} of motion each",
    ]
    if made.rest.equilibria:
        heads, rows = equilibria(made)
        out += ["", *aligned([heads, *rows])]
    for title, _, (heads, rows) in tables(made):
        out += ["", title, *(f"  {line}" for line in aligned([heads, *rows]))]
    out += ["", "Misses", *(f"  - {line}" for line in sentences(made))]
    if remarks(made):
        out += ["", "Remarks", *(f"  - {line}" for line in remarks(made))]
    return "\n".join(out) + "\n"


def as_csv(made: StabilityMap) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    judged_by = "norm" if made.motion.by_norm else "energy"
    head = ["method", "h", made.asked.axis.name, judged_by, "class", "status", "steps"]
    writer.writerow([*head, *FAR, "constant"])
    for row in made.rows:
        for p in row.points:
            place = p.method, p.h, row.x, row.motion.energy
            far = (getattr(p, name) for name in FAR)
            writer.writerow([*place, p.kind, p.status, p.steps, *far, p.constant])
    return out.getvalue()
