"""Periodic orbits as fixed points of a return map, of models with impacts and changing constraints
too: from one event of a section to a later one, by shooting with the compiled model.

The map begins and ends at DELAY of a period after the event, when the motion has its new values.
Its derivatives are central differences.

References: H. B. Keller, Numerical Solution of Two Point Boundary Value Problems (1976); A.
Goswami, B. Thuilot, B. Espiau, Int. J. Robotics Research 17 (1998) 1282 (walking).
"""

from __future__ import annotations

import argparse
import copy
from dataclasses import replace

import numpy

from pkgen.run import named
from pkgen.run.ensemble import Column, Settable
from pkgen.run.library import load
from pkgen.run.simulate import build
from pkgen.scenes import run_settings, scene
from pkgen.system.exits import DONE, UsageError
from pkgen.system.near import unknown

from .family import Family
from .problem import ITERATIONS, LAST_CORRECTION, Linear, Node, Problem, Seed

DELAY = 0.01
DIFFERENCE_STEP = 1e-4  # step of differences, in units of the state
RTOL = "1e-13"
SEARCH_TIME = 1e4  # time within which first returns are looked for
LATER_RETURNS = (0, 30, 300)  # returns after which a motion with friction may be near an orbit
NO_INFLUENCE = 1e-7  # largest derivative by a parameter without influence
ENERGY_KEPT = 1e-8  # relative change of an energy that is kept


def _closing(text: str | None, family: Family) -> dict[str, str]:
    """Returns for each start that is unknown the column that has its value again. Raises
    UsageError."""
    system = family.first
    idle = {name for k, name in enumerate(family.names()[: system.m]) if system.idle[k]}
    if text is None:
        return {name: name for name in family.names() if name not in idle}
    found = {}
    for part in text.split(","):
        name, _, column = part.partition("=")
        found[name.strip()] = column.strip() or name.strip()
    known, columns = Settable(family.compilation), _columns(family)
    for name, column in found.items():
        if name not in known:
            raise UsageError(unknown("--close", name, list(known), "start or parameter"))
        if column not in columns:
            raise UsageError(unknown("--close", column, columns, "column"))
    return found


def _columns(family: Family) -> list[str]:
    return [quantity.name for quantity in named.columns(family.compilation)]


class Returns(Problem):
    """x has the unknown starts in units of their sizes, and the parameter in units of the range. An
    energy that a return keeps is that of the start."""

    is_map = True

    def __init__(self, family: Family, options: argparse.Namespace):
        self.family, events = family, named.events(family.compilation)
        if options.section not in events:
            raise UsageError(unknown("--section", options.section, events, "event"))
        self.section = events.index(options.section)
        self.closing = _closing(options.close, family)
        known = Settable(family.compilation)
        self.unknowns: list[Column] = [known[name] for name in self.closing]
        columns = _columns(family)
        self.places = [columns.index(name) for name in self.closing.values()]
        self.settings: dict[float, object] = {}
        self.energy0: float | None = None
        self.places_of_energy = columns.index("energy") if "energy" in columns else None
        self.program = None
        self.period = self.delay = 0.0
        self.width = len(columns)

    # -- the map ------------------------------------------------------------------------------

    def _of(self, value: float):
        if value not in self.settings:
            given = {**vars(self.family._at(value)), "until": "1", "at": None, "record": None}
            if given["rtol"] is None:
                given["rtol"] = RTOL
            options, compilation = argparse.Namespace(**given), self.family.compilation
            chosen = scene.of(options, compilation.declared)
            whole = run_settings.settings(options, compilation, chosen=chosen)
            whole = replace(whole, every=None, show=(), at=None, watched=type(whole.watched)())
            self.program = self.program or build(compilation, whole, None)
            self.settings[value] = whole
        return self.settings[value]

    def _rows(self, u: numpy.ndarray | None, value: float, until: float, crossings: bool):
        """Returns the rows at the crossings of the section, or the last row; none if the run
        fails. `u` None is the model's start."""
        given = replace(self._of(value), until=until, at=self.section if crossings else None)
        if u is not None:
            kinds = {"param": "parameters", "input": "inputs", "q": "start_q", "v": "start_v"}
            for kind, name in kinds.items():
                both = zip(self.unknowns, map(float, u), strict=True)
                own = {column.index: x for column, x in both if column.kind == kind}
                others = [pair for pair in getattr(given, name) if pair[0] not in own]
                given = replace(given, **{name: (*others, *own.items())})
        run = load(self.program).run(given)
        rows = run.rows()
        return rows if run.code == DONE or crossings else rows[:0]

    def mapped(self, u: numpy.ndarray, value: float) -> tuple[numpy.ndarray, float]:
        """Returns the row after 2^doublings returns, and their time; NaN if there is none."""
        whole = 0.0
        for _ in range(2**self.doublings):
            times = self._rows(u, value, 1.5 * self.period, True)[:, 0]
            times = times[times > 0.3 * self.period]
            if not times.size:
                break
            time = times[abs(times - self.period).argmin()]
            rows = self._rows(u, value, time + self.delay, False)
            if not len(rows):
                break
            u, whole = rows[-1][self.places], whole + time + self.delay
        else:
            return rows[-1], float(whole)
        return numpy.full(self.width, numpy.nan), numpy.nan

    # -- the equations ------------------------------------------------------------------------

    def parts(self, x: numpy.ndarray) -> tuple[numpy.ndarray, float]:
        count = len(self.unknowns)
        low, _ = self.family.range
        return x[:count] * self.scale, low + float(x[-1]) * self.family.width

    def _residual(self, x: numpy.ndarray) -> numpy.ndarray:
        """Returns what the starts are off after a return, and the energy, if it is kept."""
        u, value = self.parts(x)
        row, _ = self.mapped(u, value)
        residual = (row[self.places] - u) / self.scale
        if self.energy0 is not None:
            residual = numpy.append(residual, row[self.places_of_energy] / abs(self.energy0) - 1)
        return residual

    def _linear(self, x: numpy.ndarray) -> Linear | None:
        """The derivatives of the map itself are kept for the multipliers."""
        try:
            residual = self._residual(x)
            columns = []
            for k in range(len(x)):
                by = numpy.zeros(len(x))
                by[k] = DIFFERENCE_STEP
                ends = [self._residual(x + by), self._residual(x - by)]
                columns.append((ends[0] - ends[1]) / (2 * DIFFERENCE_STEP))
        except UsageError:
            return None
        jacobian = numpy.array(columns).T
        if not (numpy.isfinite(residual).all() and numpy.isfinite(jacobian).all()):
            return None
        count = len(self.unknowns)
        self.map_jacobian = jacobian[:count, :count] + numpy.eye(count)
        return Linear(residual, jacobian, lambda step, _: step, float(abs(residual).max()))

    def correct(self, x: numpy.ndarray, row: numpy.ndarray, last: float):
        """As of other problems, with the derivatives at the last point while they are good enough:
        each of them is an integration."""
        jacobian, before = self.last[2] and self.last[2].jacobian, numpy.inf
        for k in range(3 * ITERATIONS):
            if jacobian is None:
                at = self.linear(x)
                if at is None:
                    return None
                jacobian = at.jacobian
            matrix = numpy.concatenate([jacobian, row[None]])
            right = numpy.append(-self._residual(x), last - row @ x)
            if not numpy.isfinite(right).all():
                return None
            step = numpy.linalg.lstsq(matrix, right, rcond=self.flat)[0]
            x, size = x + step, abs(step).max()
            if not size < 1:
                return None
            if size < LAST_CORRECTION:
                at = self.linear(x)
                return (x, k // 3) if at is not None and at.size < 1e-7 else None
            jacobian = None if size > 0.2 * before else jacobian
            before = size
        return None

    def node(self, x: numpy.ndarray, t: numpy.ndarray) -> Node | None:
        if self.linear(x) is None:
            return None
        values = numpy.linalg.eigvals(self.map_jacobian)
        values = values[numpy.argsort(abs(values - 1))]
        u, value = self.parts(x)
        _, time = self.mapped(u, value)
        self.period = time / 2**self.doublings  # the next ones are near it
        both = [*zip(self.unknowns, map(float, u), strict=True)]
        sets = {c.name: x for c, x in both if c.kind in ("param", "input")}
        about = {"state": {c.name: x for c, x in both}, "set": sets, "period": time}
        values = values[self.energy0 is not None :]  # without that of the energy
        return Node(x, t, value, float(t[-1]) * self.family.width, values, about)

    def apart(self, a: Node, b: Node) -> numpy.ndarray:
        return b.x - a.x

    def doubled(self, node: Node) -> tuple[Problem, Node] | None:
        twice = copy.copy(self)
        twice.doublings, twice.last = self.doublings + 1, (None,) * 3
        other = twice.aside(node)
        made = None if other is None else twice.beside(node.x, other)
        return None if made is None else (twice, made)

    # -- the first orbit ----------------------------------------------------------------------

    def seeds(self) -> list[Seed]:
        """Returns the fixed point near the motion of the start. Raises UsageError."""
        if self.family.name is None:
            raise UsageError("--section is followed along a parameter")
        value, until, times = self.family.own(), 1.0, numpy.zeros(0)
        while len(times) < 3 and until < SEARCH_TIME:
            until *= 4
            rows = self._rows(None, value, until, True)
            times = rows[:, 0] if len(rows) else times
        if len(times) < 3:
            raise UsageError("--section: from the start on its event does not happen three times")
        for later in LATER_RETURNS:
            if later:
                rows = self._rows(None, value, times[0] + 1.2 * later * (times[1] - times[0]), True)
                times = rows[:, 0]
            if len(times) < 2:
                continue
            k = max(0, len(times) - 3) if later else 0
            self.delay = DELAY * float(times[k + 1] - times[k])
            rows = self._rows(None, value, times[k] + self.delay, False)
            if not len(rows):
                continue
            u = rows[-1][self.places]
            first = self._rows(u, value, 2 * float(times[k + 1] - times[k]), True)[:, 0]
            first = first[first > 2 * self.delay]
            if not first.size:
                continue
            self.period = float(first[0])
            if (place := self.places_of_energy) is not None:
                energy, later_one = rows[-1][place], self.mapped(u, value)[0][place]
                kept = abs(later_one - energy) <= ENERGY_KEPT * abs(energy)
                self.energy0 = energy if kept else None
            self.scale = numpy.fmax(abs(u), 0.1 * abs(u).max())
            x = numpy.append(u / self.scale, (value - self.family.range[0]) / self.family.width)
            row = numpy.zeros(len(x))
            row[-1] = 1
            found = self.correct(x, row, float(x[-1]))
            if found and not abs(self.linear(found[0]).jacobian[:, -1]).max() > NO_INFLUENCE:
                raise UsageError(self.family.without_influence())
            node = found and self.node(found[0], self.tangent(found[0], row))
            if node:
                return [Seed(self, node)]
        raise UsageError("no fixed point of the return map was found near the motion of the start")
