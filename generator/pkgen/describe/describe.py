"""Describes a compiled model as data; docs/dev/describe.md has the schema."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import suppress

from ..compiler import Compilation
from ..equations import Quantity
from ..front.check.scene_numbers import Values, WrongValue
from ..indices import hidden, parted
from ..methods import Method, known, provides
from ..middle.loops.switches import switch_count
from ..middle.quantities import single_rotations
from ..model import Model, Parameter, Scene
from ..plan import default_method
from ..run import named
from ..run.build import own_methods, runtime_methods
from ..run.methods_table import in_words
from ..run.settings import Settings
from ..tree import names
from ..version import __version__
from .constants import constants
from .drawing import drawing
from .scenes import LISTED, described_scene, members_of

SCHEMA = 1

Given = dict[str, list[float]]  # parameters and initial values, from Run.given()


def described(
    compilation: Compilation,
    settings: Settings,
    given: Given,
    scene: Scene | None = None,
    draw: bool = True,
) -> dict[str, object]:
    """Returns the description of a model. `draw` says that the model was compiled with the outputs
    that drawn() adds. `given` has the parameters and the start, as the compiled library computed
    them."""
    model = compilation.declared
    return {
        "schema": SCHEMA,
        "pkgen": __version__,
        "model": compilation.model.name,
        "title": title(model),
        "description": model.description,
        "source": os.path.basename(model.source.path),
        "sha256": model.source.sha256,
        "dimensionless": model.dimensionless,
        "scene": None if scene is None else scene.name,
        "looped": compilation.looped,
        "run": {
            "until": settings.until,
            "every": settings.every,
            "method": settings.method,
            "step": settings.step,
            "rtol": settings.rtol,
        },
        "parameters": list(_parameters(compilation, settings, given)),
        "inputs": [
            {**_named(q, k), "value": dict(settings.inputs).get(k, 0.0)}
            for k, q in enumerate(_each(named.inputs(compilation)))
        ],
        "coordinates": list(_coordinates(compilation, settings, given)),
        "states": list(_states(compilation, settings, given)),
        "rotations": list(_rotations(compilation, settings, given)),
        "outputs": [
            {**_named(q, k), "hidden": hidden(q.name)}
            for k, q in enumerate(named.observed(compilation))
        ],
        "whole": _whole(compilation),
        "switches": _switches(compilation),
        "constants": list(constants(compilation)),
        "events": list(_events(compilation)),
        "constraints": [
            {"name": c.name, "holonomic": c.holonomic, "unit": c.unit} for c in model.constraints
        ],
        "methods": list(_methods(compilation, settings)),
        "scenes": [described_scene(compilation, s) for s in model.scenes if not hidden(s.name)],
        "drawing": drawing(compilation) if draw else None,
    }


def title(model: Model) -> str:
    """Returns the first line of the text if it is a comment that looks like a title: it begins with
    a capital letter and has no period at the end. Otherwise returns the model's name in words."""
    comment = model.source.text.lstrip().partition("\n")[0].partition("#")[2].strip()
    if comment[:1].isupper() and not comment.endswith("."):
        return comment
    words = model.name.replace("_", " ")
    return words[0].upper() + words[1:]


def _named(q: Quantity, index: int) -> dict[str, object]:
    return {"name": q.name, "index": index, "unit": q.unit, "description": q.description}


def _each(found: named.Named) -> Iterator:
    for item in found.declared:
        yield item.quantity


def _flat(found: named.Named) -> Iterator[tuple[int, int, int, named.Declared, object]]:
    """Yields the members of all families, and the single names, as (flat index, number of the
    declaration, position in the family, declaration, quantity). Members of families with more than
    LISTED members are left out."""
    for k, item in enumerate(found.declared):
        if item.count <= LISTED:
            for position in range(item.count):
                index = None if item.lo is None else item.lo + position
                yield item.first + position, k, position, item, item.member(index)


def _parameters(
    compilation: Compilation, settings: Settings, given: Given
) -> Iterator[dict[str, object]]:
    model = compilation.declared
    chosen = {*dict(settings.parameters), *((k, j) for k, j, _ in settings.members)}
    declared = {p.name: p for p in model.parameters}
    values = Values(model, {})
    for flat, k, position, item, quantity in _flat(named.parameters(compilation)):
        place = flat if not compilation.looped else k if item.lo is None else (k, position)
        name, index = parted(quantity.name)
        own = declared.get(name)
        found: dict[str, object] = {
            **_named(quantity, flat),
            "value": _number(given["parameters"], flat),
            **_bounds(values, own, index),
            "follows": own is not None and own.follows and place not in chosen,
        }
        if compilation.looped:
            found["place"] = [k, position]
        yield found


def _bounds(values: Values, item: Parameter | None, index: int | None) -> dict[str, object]:
    """Returns the bounds of a parameter; an infinite bound is None. `item` is None for a start that
    became a parameter, which has no bounds."""
    found: dict[str, object] = {"lo": None, "hi": None, "lo_open": True, "hi_open": True}
    if item is None:
        return found
    loop = {**values.sizes}
    if item.range is not None and index is not None:
        loop[item.range.variable] = index
    for end in ("lo", "hi"):
        expr = getattr(item.bounds, end)
        if expr is not None:
            with suppress(WrongValue):
                found[end] = values.number(item.name, expr, loop)
                found[f"{end}_open"] = getattr(item.bounds, f"{end}_open")
    return found


def _whole(compilation: Compilation) -> bool:
    """Whether every family is short enough to be listed in full."""
    kinds = (named.parameters, named.inputs, named.coordinates)
    return all(item.count <= LISTED for kind in kinds for item in kind(compilation).declared)


def _switches(compilation: Compilation) -> int:
    """Returns the number of arguments of step, abs etc. at whose zeros the equations change."""
    e = compilation.equations
    return switch_count(e) if compilation.looped else len(e.switches)


def _number(row: list[float], k: int) -> float | None:
    return row[k] if k < len(row) and math.isfinite(row[k]) else None


def _coordinates(
    compilation: Compilation, settings: Settings, given: Given
) -> Iterator[dict[str, object]]:
    rates = [q for *_, q in _flat(named.coordinates(compilation, rates=True))]
    momenta = {c.name: c for c in compilation.declared.coordinates}
    follow = _following(compilation.model)
    set_q, set_v = dict(settings.start_q), dict(settings.start_v)
    for flat, _, _, item, quantity in _flat(named.coordinates(compilation)):
        own = momenta.get(parted(quantity.name)[0])
        rate = next((r for r in rates if r.name == f"{quantity.name}'"), None)
        yield {
            **_named(quantity, flat),
            "rate": f"{quantity.name}'",
            "rate_unit": rate.unit if rate else (own.rate_unit if own else ""),
            "momentum": f"p_{quantity.name}",
            "momentum_unit": own.momentum_unit if own else "",
            "q": _number(given["q"], flat),
            "v": _number(given["v"], flat),
            "q_follows": flat not in set_q and follow(quantity.name, 0),
            "v_follows": flat not in set_v and follow(quantity.name, 1),
            "periodic": own is not None and own.unit == "rad",
            "family": item.quantity.name if item.lo is not None else None,
        }


def _following(model: Model) -> Callable[[str, int], bool]:
    """Returns a function of (name, order). It says whether the start of a coordinate (order 0) or
    of its rate (order 1) depends on parameters. If several statements set a start, the last one
    counts."""
    moving = {p.name for p in model.parameters}
    for item in sorted(model.definitions, key=lambda d: d.span.start):
        if names(item.value) & moving:
            moving.add(item.name)
    found: dict[tuple[str, int | None, int], bool] = {}
    for item in model.starts:
        for index in members_of(model, item):
            found[item.name, index, item.order] = bool(names(item.value) & moving)
    return lambda name, order: found.get((*parted(name), order), False)


def _states(
    compilation: Compilation, settings: Settings, given: Given
) -> Iterator[dict[str, object]]:
    """Yields the first-order variables; their indices follow the indices of the rates."""
    known = named.states(compilation)
    follow, set_v = _following(compilation.model), dict(settings.start_v)
    for flat, _, _, _, quantity in _flat(named.coordinates(compilation, rates=True)):
        if quantity.name in known:
            yield {
                **_named(quantity, flat),
                "value": _number(given["v"], flat),
                "follows": flat not in set_v and follow(quantity.name, 0),
            }


def _rotations(
    compilation: Compilation, settings: Settings, given: Given
) -> Iterator[dict[str, object]]:
    follow, set_v = _following(compilation.model), dict(settings.start_v)
    indices = {q.name: k for k, *_, q in _flat(named.coordinates(compilation, rates=True))}
    for r in single_rotations(compilation.declared):
        found = [indices.get(name) for name in r.rates]
        follows = [follow(name, 1) for name in r.turns]
        yield {
            "name": r.name,
            "quaternion": list(r.quaternion),
            "rates": list(r.rates),
            "rate_indices": found,
            "rate_values": [None if k is None else _number(given["v"], k) for k in found],
            "rates_follow": [f and k not in set_v for f, k in zip(follows, found, strict=True)],
            "rate_unit": r.rate_unit,
            "description": r.description,
        }


def _events(compilation: Compilation) -> Iterator[dict[str, object]]:
    declared = {event.name: event for event in compilation.declared.events}
    for k, name in enumerate(named.events(compilation)):
        own = declared[name]
        yield {
            **_named(Quantity(name, own.unit, own.description), k),
            "direction": own.direction,
            "stop": own.stop,
        }


def _methods(compilation: Compilation, settings: Settings) -> Iterator[dict[str, object]]:
    """Yields the model's own methods, then those of the runtime and GSL, with the reason why a
    method does not apply."""
    own = compilation.model.methods
    all_methods = known(own)
    made = compilation.equations, compilation.structure
    default = default_method(made, settings.rtol, exact=False)
    for item in [*own_methods(own), *runtime_methods()]:
        name = str(item["name"])
        why = _why_not(compilation, all_methods.get(name), item)
        yield {
            "name": name,
            "order": item["order"] or None,
            "stages": item["stages"] or None,
            "adaptive": "adaptive" in item["flags"],
            "exact": "exact" in item["flags"],
            "symplectic": "symplectic" in item["flags"],
            "own": name in {method.name for method in own},
            "gsl": name.startswith("gsl_"),
            "applies": not why,
            "why": why,
            "default": name == default,
            "doc": item["doc"],
        }


# For a flag of a method: the kernels that the method needs, and that models compiled to loops do
# not have. The runtime refuses such a method too.
_NOT_OF_LOOPS = {
    "holonomic": "M",
    "jacobians": "Jacobians",
}


def _why_not(compilation: Compilation, method: Method | None, item: dict) -> str:
    requires = method.requires if method else tuple(item["requires"])
    missing = [fact for fact in requires if not provides(compilation.structure, fact)]
    if missing:
        return "it is for systems that are " + ", ".join(in_words(missing)) + ": not proved of this"
    if "no_inputs" in item["flags"] and named.inputs(compilation).count:
        return "it is for systems without inputs"
    rolling = [c.name for c in compilation.model.constraints if not c.holonomic]
    if "holonomic" in item["flags"] and rolling:
        return (
            f"it takes constraints of positions alone: {rolling[0]} is one of the rates (rolling)"
        )
    linear = not compilation.looped and compilation.equations.linear is not None
    if "linear" in item["flags"] and not linear:
        return "it needs the derivatives of the acceleration, which so many coordinates are without"
    if compilation.looped:
        for flag, kernels in _NOT_OF_LOOPS.items():
            if flag in item["flags"]:
                return f"it needs {kernels}, which families that are kept as loops do not have"
    return ""
