"""Checks the numbers of a scene: bounds, signs, and times within the run.

Parameters have the values of the model and the scene. Options of the command line may change them,
so the package `scenes` and the C code check again.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

from ...indices import indexed, integer
from ...model import Model, Parameter, Record, Scene
from ...source import Span
from ...tree import Expr
from .names import Report
from .params import ends_of, interval, number, within
from .scene_numbers import Values, WrongValue, has_row, too_much


def check_scene_values(model: Model, scene: Scene, report: Report) -> None:
    _Numbers(model, scene, report).check()


# The shortest step, as a fraction of the duration of a run. The limit in main.c is the same.
SHORTEST = 10 * sys.float_info.epsilon


class _Numbers:
    def __init__(self, model: Model, scene: Scene, report: Report) -> None:
        self.model, self.scene, self.report, self.error = model, scene, report, report.error
        self.values = Values(model, {})

    def check(self) -> None:
        self._assignments()
        scene, values = self.scene, self.values
        until = self._of(lambda: values.positive("until", scene.until))
        self._interval("step", scene.step, until)
        self._of(lambda: values.rtol(scene.rtol))
        every = None
        if scene.record is not None:
            every = self._interval("every", scene.record.every, until)
            self._rows(scene.record, every, until)
        for item in scene.expects:
            self._of(lambda item=item: values.not_negative("within", item.within))
            at = self._of(lambda item=item: values.not_negative("at", item.at))
            if at is not None and until is not None and at > until:
                message = f"t = {number(at)} is not reached: the scene runs until {number(until)}"
                self.error(message, item.at, "expect it earlier, or run longer")
            elif scene.swarm and at and until and not has_row(at, every, until):
                message = f"members of a swarm have no row at t = {number(at)}"
                self.error(message, item.at, "expect it at a recorded time")

    def _interval(self, name: str, expr: Expr | None, until: float | None) -> float | None:
        """Returns a step or interval; reports one that is too long or too short for the run."""
        found = self._of(lambda: self.values.positive(name, expr))
        if found is None or until is None:
            return found
        if found > until:
            message = f"'{name}' is {number(found)}: the scene runs no longer than {number(until)}"
            self.error(message, expr)
        elif found < SHORTEST * until:
            least = number(SHORTEST * until)
            self.error(f"'{name}' is below the round-off of the time, {least}", expr)
        return found

    def _rows(self, record: Record, every: float | None, until: float | None) -> None:
        """Reports a clause `record` whose rows together have more than limits.WRITTEN numbers."""
        if until is None or (every and every < SHORTEST * until):  # The error is reported already.
            return
        members, swarm = None, self.scene.swarm
        if swarm is not None:
            lo, hi = (integer(end, self.values.sizes) for end in (swarm.lo, swarm.hi))
            members = hi - lo + 1
        said = too_much(until / every + 1 if every else 1, len(record.columns) + 1, members)
        if said and swarm is not None:
            self.error(said, swarm, "take fewer members")
        elif said:
            self.error(said, record.every, "take a longer interval")

    def _of(self, value: Callable[[], float | None]) -> float | None:
        try:
            return value()
        except WrongValue as wrong:
            self.error(str(wrong), wrong, wrong.help)
            return None

    def _assignments(self) -> None:
        """Evaluates the assignments in order; reports parameters outside their bounds."""
        parameters = {p.name: p for p in self.model.parameters}
        given: dict = {}
        outside: set[str] = set()  # Each parameter is reported once.
        for item in self.scene.assignments:
            if item.varies:
                continue
            for index, value in self._of(lambda item=item: self.values.assigned(item)) or ():
                if item.name in parameters:
                    given[item.name, index] = value
            self.values.set(given)
        for item in self.scene.assignments:
            if item.name in parameters and item.name not in outside:
                message = "{} is set outside its bounds"
                if self._outside(parameters[item.name], item.span, message):
                    outside.add(item.name)
        for parameter in self.model.parameters:
            if given and parameter.follows and parameter.name not in outside:
                message = "this puts {}, which follows it, outside its bounds"
                self._outside(parameter, self.scene.assignments[-1].span, message)

    def _outside(self, parameter: Parameter, span: Span, message: str) -> bool:
        ends = ends_of(parameter, self.values.values, self.values.sizes, self.report)
        for index, key in self.values.members(parameter):
            value = self.values.values.get(key)
            if ends is None or value is None or within(value, parameter.bounds, ends):
                continue
            said = message.format(indexed(parameter.name, index))
            value, bounds = number(value, parameter.unit), interval(parameter.bounds, ends)
            self.error(f"{said}: {value} is not in {bounds}", span)
            return True
        return False
