"""`--scene NAME`: what a scene makes of its model, and the numbers that it sets for a run.

A scene's starts and what it records beside coordinates, rates, observed names and the energy are
compiled with the model. Its numbers are settings of the run, computed here with the parameters'
values, so that options of the command line can override them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from . import limits
from .exits import UsageError
from .front.check_values import NoValue, evaluate
from .indices import assignments, integer
from .middle.quantities import families, sizes
from .model import Assignment, Definition, Model, Parameter, Record, Scene
from .option_values import unknown
from .source import Span
from .tree import Expr, Name, Prime

Number = Fraction | float
Key = tuple[str, int | None]  # a name and the index of a member


def chosen(model: Model, name: str) -> Scene:
    """The scene of that name, if it can be run. Raises UsageError."""
    scenes = {scene.name: scene for scene in model.scenes}
    if name not in scenes:
        raise UsageError(unknown("--scene", name, scenes, "scene"))
    scene = scenes[name]
    if scene.refused:
        why, span = scene.refused[0]
        raise UsageError(f"{place(model, span)}: scene '{name}': {why}")
    for item in scene.assignments:
        if item.varies:
            raise UsageError(
                f"{place(model, item.span)}: scene '{name}': an input as a function of t cannot "
                "be run yet; give it a constant, or write the function where the input stands"
            )
    return scene


def used(model: Model, scene: Scene) -> Model:
    """The model with the scene's starts, and outputs for what no column has yet."""
    extra: dict[str, Definition] = {}
    for item in scene.record.columns if scene.record else ():
        if _kind(model, item) is None:
            extra[item.name] = item
    return replace(
        model,
        starts=(*model.starts, *scene.starts),
        observed=(*model.observed, *extra.values()),
    )


def columns(scene: Scene) -> list[str]:
    """The names of what it records."""
    return [item.name for item in scene.record.columns] if scene.record else []


def hidden(model: Model, scene: Scene) -> frozenset[str]:
    """Outputs of the model as it is used that are not recorded, and yet needed."""
    return frozenset()


def events(scene: Scene) -> frozenset[str]:
    """Events that it asks about, besides the one at which it records."""
    return frozenset()


def _kind(model: Model, item: Definition) -> str | None:
    """The kind of a column that each run has; None where there is no such column."""
    rate = isinstance(item.value, Prime)
    value = item.value.of if rate else item.value
    if not isinstance(value, Name):
        return None
    if value.id in {c.name for c in model.coordinates}:
        return "v" if rate else "q"
    if not rate and value.id in {o.name for o in model.observed}:
        return "observed"
    return "energy" if item.name == "energy" else None


def place(model: Model, span: Span) -> str:
    line, column = model.source.position(span.start)
    return f"{model.source.path}:{line}:{column}"


@dataclass(frozen=True)
class Numbers:
    """What a scene sets, in SI; None, "" and nothing where it says nothing."""

    parameters: dict[Key, float]
    inputs: dict[str, float]
    until: float | None = None
    method: str = ""
    step: float | None = None
    rtol: float | None = None
    record: Record | None = None
    every: float | None = None


def numbers(model: Model, scene: Scene, given: Mapping[Key, float]) -> Numbers:
    """The scene's settings where the command line has set the parameters in `given`."""
    found = _Values(model, scene, dict(given))
    parameters: dict[Key, float] = {}
    inputs: dict[str, float] = {}
    names = {p.name for p in model.parameters}
    for item in scene.assignments:
        for index, value in found.assigned(item):
            if item.name not in names:
                inputs[item.name] = value
            elif (item.name, index) not in given:
                parameters[item.name, index] = value
        found.set(parameters)
    return Numbers(
        parameters,
        inputs,
        until=found.positive("until", scene.until),
        method=scene.method,
        step=found.positive("step", scene.step),
        rtol=found.positive("rtol", scene.rtol),
        record=scene.record,
        every=found.positive("every", scene.record.every) if scene.record else None,
    )


class _Values:
    """Values of a model's parameters and constants, and of expressions of these."""

    def __init__(self, model: Model, scene: Scene, given: dict[Key, float]):
        self.model, self.scene, self.given = model, scene, given
        self.sizes = sizes(model)
        self.values: dict[object, Number] = {}
        self.set({})

    def set(self, more: Mapping[Key, float]) -> None:
        """Computes all values anew, parameters in `more` set beside those given at first."""
        given = {**more, **self.given}
        self.values.clear()
        items = (*self.model.parameters, *self.model.definitions)
        for item in sorted(items, key=lambda x: x.span.start):
            if isinstance(item, Parameter):
                self._parameter(item, given)
            elif item.range is None and item.index is None:
                self._keep(item.name, item.value, self.sizes)

    def _parameter(self, item: Parameter, given: Mapping[Key, float]) -> None:
        members = families(self.model, (item,))[item.name].members
        for index in members if len(members) <= limits.SAMPLED else ():
            key = item.name if index is None else (item.name, index)
            if (item.name, index) in given:
                self.values[key] = given[item.name, index]
            else:
                loop = {} if index is None else {item.range.variable: index}
                self._keep(key, item.default, {**self.sizes, **loop})

    def _keep(self, key: object, expr: Expr, loop: Mapping[str, int]) -> None:
        try:
            self.values[key] = evaluate(expr, self.values, loop)
        except (NoValue, KeyError):  # a definition of the motion, or a value that C reports
            self.values.pop(key, None)

    def assigned(self, item: Assignment) -> list[tuple[int | None, float]]:
        if item.range is None:
            index = None if item.index is None else integer(item.index, self.sizes)
            return [(index, self.number(item.name, item.value, self.sizes))]
        return [
            (loop[item.range.variable], self.number(item.name, item.value, loop))
            for loop in assignments((item.range,), self.sizes)
        ]

    def number(self, name: str, expr: Expr, loop: Mapping[str, int]) -> float:
        try:
            return float(evaluate(expr, self.values, loop))
        except KeyError as missing:
            raise self._wrong(name, f"the value of {missing} is not known here", expr) from None
        except NoValue as error:
            raise self._wrong(name, str(error), expr) from None

    def positive(self, name: str, expr: Expr | None) -> float | None:
        if expr is None:
            return None
        found = self.number(name, expr, self.sizes)
        if not found > 0:
            raise self._wrong(name, "must be positive", expr)
        return found

    def _wrong(self, name: str, why: str, expr: Expr) -> UsageError:
        at = place(self.model, expr.span)
        return UsageError(f"{at}: scene '{self.scene.name}': {name}: {why}")
