"""Finds the scene that --scene names, and computes the numbers that it sets for a run.

A scene's starts and recorded expressions are compiled with the model. Its numbers, such as the step
size, are settings of the run, so that options can override them.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import field

from ..front.check.names import Report
from ..front.check.scene_numbers import Key, Values, WrongValue
from ..front.check.scene_values import check_scene_values
from ..model import Model, Scene
from ..plan import RunNumbers
from ..record import record
from ..source import ModelError, Span
from ..system.exits import UsageError
from ..system.near import unknown


def chosen(model: Model, name: str) -> Scene:
    """Returns the scene of a model with a given name. Raises UsageError if there is none,
    ModelError if --size makes it invalid."""
    scenes = {scene.name: scene for scene in model.scenes}
    if name not in scenes:
        raise UsageError(unknown("--scene", name, scenes, "scene"))
    report = Report()
    report.errors += scenes[name].misfits
    if not report.errors and not scenes[name].listed:
        check_scene_values(model, scenes[name], report)
    if report.errors:
        raise ModelError(model.source, report.errors)
    return scenes[name]


def of(options: argparse.Namespace, model: Model) -> Scene | None:
    """Returns the scene that --scene chooses, or None."""
    return chosen(model, options.scene) if options.scene else None


def wrong(model: Model, scene: Scene, span: Span, why: object) -> UsageError:
    """Returns a UsageError whose message has the place of an error in the scene, and the reason
    `why`."""
    return UsageError(f"{model.source.place(span)}: scene '{scene.name}': {why}")


@record
class Numbers(RunNumbers):
    """All numbers that a scene sets. A number that it does not set is None or missing."""

    parameters: dict[Key, float] = field(default_factory=dict)
    inputs: dict[str, float] = field(default_factory=dict)
    accuracy: float | None = None


def values(model: Model, scene: Scene, given: Mapping[Key, float]) -> Values:
    """Returns the values of all parameters and constants in a run of the scene. `model` is the
    model as declared, without reductions."""
    names = {p.name for p in model.parameters}
    found = Values(model, {key: x for key, x in given.items() if key[0] in names})
    numbers(model, scene, given, found)
    return found


def numbers(
    model: Model, scene: Scene, given: Mapping[Key, float], found: Values | None = None
) -> Numbers:
    """Returns the numbers that the scene sets. `given` has the parameters set by options. The
    values of parameters are added to `found`."""
    found = found or Values(model, given)
    try:
        return _numbers(found, scene, given)
    except WrongValue as error:
        raise wrong(model, scene, error.span, error) from None


def _numbers(found: Values, scene: Scene, given: Mapping[Key, float]) -> Numbers:
    parameters: dict[Key, float] = {}
    inputs: dict[str, float] = {}
    names = {p.name for p in found.model.parameters}
    for item in scene.assignments:
        if item.varies:  # A function of t is no number, but part of the compiled model.
            continue
        for index, value in found.assigned(item):
            if item.name not in names:
                inputs[item.name] = value
            elif (item.name, index) not in given:
                parameters[item.name, index] = value
        found.set(parameters)
    return Numbers(
        parameters=parameters,
        inputs=inputs,
        until=found.positive("until", scene.until),
        step=found.positive("step", scene.step),
        rtol=found.rtol(scene.rtol),
        every=found.positive("every", scene.record.every) if scene.record else None,
        accuracy=found.positive("accuracy", scene.accuracy),
    )
