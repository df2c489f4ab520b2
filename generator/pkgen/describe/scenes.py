"""The part of a model's description on its scenes."""

from __future__ import annotations

from contextlib import suppress

from ..compiler import Compilation
from ..front.check.scene_numbers import WrongValue
from ..indices import NotAnInteger, indexed, integer
from ..middle.quantities import ends, sizes
from ..model import Model, Scene, Start
from ..run.ensemble import Settable
from ..scenes import scene as scenes
from ..source import ModelError
from ..system.exits import UsageError

SHOWN = 2000  # A description has the starts of at most this many members of a swarm.
LISTED = 1000  # The members of a larger family are not described one by one.


def members_of(model: Model, item: Start) -> list[int | None]:
    """Returns the indices of the members that a start statement sets; [] if more than LISTED."""
    if item.range is None:
        return [None if item.index is None else integer(item.index, sizes(model))]
    lo, hi = ends(model, item.range)
    return list(range(lo, hi + 1)) if hi - lo < LISTED else []


def described_scene(compilation: Compilation, scene: Scene) -> dict[str, object]:
    model = compilation.declared
    found: dict[str, object] = {"name": scene.name, "description": scene.description}
    keys = ("until", "step", "rtol", "accuracy", "every")
    found |= dict.fromkeys((*keys, "method"))
    found |= {"set": {}, "start": {}, "swarm": None}
    with suppress(UsageError, ModelError, WrongValue, NotAnInteger):
        numbers = scenes.numbers(model, scene, {})
        found |= {key: getattr(numbers, key) for key in keys}
        found["method"] = scene.method or None
        found["set"] = {indexed(*key): x for key, x in numbers.parameters.items()}
        found["set"] |= numbers.inputs
        found["start"] = _starts(model, scene)
        if scene.swarm is not None:
            lo, hi = (integer(end, sizes(model)) for end in (scene.swarm.lo, scene.swarm.hi))
            found["swarm"] = {"first": lo, "last": hi, **_members_of(compilation, scene)}
    return found


def _members_of(compilation: Compilation, scene: Scene) -> dict[str, object]:
    """Returns the starts and parameters that differ between the motions of a swarm, and their
    values for at most SHOWN evenly spaced motions. Returns {} if a value cannot be computed."""
    from ..scenes.swarm import members  # NumPy

    model = compilation.declared
    try:
        found = members(model, scene, scenes.values(model, scene, {}), Settable(compilation), ())
    except UsageError:
        return {}
    few = found.values[:: -(-len(found.values) // SHOWN)]
    values = [float(f"{x:.9g}") for x in few.ravel()]
    return {"columns": [column.name for column in found.columns], "values": values}


def _starts(model: Model, scene: Scene) -> dict[str, float]:
    """Returns the start values of a scene, computed with the scene's parameter values. Starts that
    differ between the members of a swarm are left out."""
    values = scenes.values(model, scene, {})
    found = {}
    for item in scene.starts:
        for index in members_of(model, item):
            loop = {item.range.variable: index} if item.range else {}
            with suppress(WrongValue):
                name = indexed(item.name, index) + "'" * item.order
                found[name] = values.number(item.name, item.value, {**sizes(model), **loop})
    return found
