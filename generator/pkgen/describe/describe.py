"""Describes a compiled model as data; docs/dev/describe.md has the schema."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import suppress

from ..compiler import Compilation
from ..equations import Quantity
from ..front.check.scene_numbers import Values, WrongValue
from ..indices import hidden, made_of, parted
from ..methods import Method, known, provides
from ..middle.quantities import block_of, single_rotations
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
Entries = Iterator[dict[str, object]]


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
    model, of = compilation.declared, _Description(compilation, settings, given)
    kinds = {"contact": model.contacts, "friction": model.frictions, "mode": model.modes}
    own = ((x, "" if getattr(x, "of", "") else kind) for kind in kinds for x in kinds[kind])
    meets = {x.name: kind for x, kind in own}  # without a kind: the friction of a contact
    return {
        "schema": SCHEMA,
        "pkgen": __version__,
        "model": compilation.model.name,
        "title": title(model),
        "description": model.description,
        "source": os.path.basename(model.source.path),
        "sha256": model.sha256,
        "dimensionless": model.dimensionless,
        "scene": None if scene is None else scene.name,
        "looped": any(x.lo is not None for x in of.of_rates.declared),
        "run": {
            name: getattr(settings, name) for name in ("until", "every", "method", "step", "rtol")
        },
        "parameters": list(of.parameters()),
        "inputs": [
            {
                **_named(item.quantity, k),
                "value": dict(settings.inputs).get(k, 0.0),
                **({"sampled_by": by} if (by := block_of(model, item.quantity.name)) else {}),
                **({"hidden": True} if by in meets else {}),
            }
            for k, item in enumerate(named.inputs(compilation).declared)
        ],
        **({"samples": list(of.samples())} if model.samples else {}),
        **({"contacts": [{"name": x, "kind": k} for x, k in meets.items() if k]} if meets else {}),
        "coordinates": list(of.coordinates()),
        "states": list(of.states()),
        "rotations": list(of.rotations()),
        "outputs": [
            {**_named(q, k), "hidden": hidden(q.name)}
            for k, q in enumerate(named.observed(compilation))
        ],
        "whole": of.whole(),
        "switches": of.switches(),
        "tables": [
            {"name": x.name, "units": list(x.units), "kind": x.kind, "outside": x.outside}
            | {"file": os.path.basename(x.file), "knots": [len(a.knots) for a in x.data.axes]}
            | {"description": x.description}
            for x in model.tables
        ],
        "constants": list(constants(compilation)),
        "events": list(of.events()),
        "constraints": [
            {"name": c.name, "holonomic": c.holonomic, "unit": c.unit} for c in model.constraints
        ],
        "methods": list(of.methods()),
        "scenes": [described_scene(compilation, s) for s in model.scenes if s.listed],
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


def _flat(found: named.Named) -> Iterator[tuple[int, int, int, named.Declared, object]]:
    """Yields the members of all families, and the single names, as (flat index, number of the
    declaration, position in the family, declaration, quantity). Members of families with more than
    LISTED members are left out."""
    for k, item in enumerate(found.declared):
        if item.count <= LISTED:
            for position in range(item.count):
                index = None if item.lo is None else item.lo + position
                yield item.first + position, k, position, item, item.member(index)


class _Description:
    """The parts of a description that depend on the settings and the start."""

    def __init__(self, compilation: Compilation, settings: Settings, given: Given):
        self.compilation, self.settings, self.given = compilation, settings, given
        self.declared = compilation.declared
        self.of_places = named.coordinates(compilation)
        self.of_rates = named.coordinates(compilation, rates=True)
        self.follow = _following(compilation.model)
        self.set_q, self.set_v = dict(settings.start_q), dict(settings.start_v)

    def parameters(self) -> Entries:
        chosen = {*dict(self.settings.parameters), *((k, j) for k, j, _ in self.settings.members)}
        declared = {p.name: p for p in self.declared.parameters}
        values = Values(self.declared, {})
        for flat, k, position, item, quantity in _flat(named.parameters(self.compilation)):
            place = k if item.lo is None else (k, position)
            name, index = parted(quantity.name)
            own = declared.get(name)
            found: dict[str, object] = {
                **_named(quantity, flat),
                "value": _number(self.given["parameters"], flat),
                **_bounds(values, own, index),
                "follows": own is not None and own.follows and place not in chosen,
            }
            yield found | ({} if self.compilation.equations.dense else {"place": [k, position]})

    def samples(self) -> Entries:
        names = enumerate(named.parameters(self.compilation).names())
        given = {name: self.given["parameters"][k] for k, name in names}
        values = Values(self.declared, {parted(name): x for name, x in given.items()})
        for block in self.declared.samples:
            yield {
                "name": block.name,
                "every": values.number("every", block.every),
                "offset": 0.0 if block.offset is None else values.number("offset", block.offset),
                "delay": block.delay,
                "sets": [
                    x.name for x in self.declared.inputs if x.by == block.name and "." not in x.name
                ],
                "description": block.description,
            }

    def whole(self) -> bool:
        """Whether every family is short enough to be listed in full."""
        every = named.parameters(self.compilation), named.inputs(self.compilation), self.of_places
        return all(item.count <= LISTED for of in every for item in of.declared)

    def switches(self) -> int:
        """Returns the number of arguments of step, abs etc. at whose zeros the equations change."""
        return self.compilation.equations.n_switches

    def coordinates(self) -> Entries:
        units = {q.name: q.unit for *_, q in _flat(self.of_rates)}
        declared = {c.name: c for c in self.declared.coordinates}
        for flat, _, _, item, quantity in _flat(self.of_places):
            own, rate = declared.get(parted(quantity.name)[0]), f"{quantity.name}'"
            yield {
                **_named(quantity, flat),
                "rate": rate,
                "rate_unit": units.get(rate, own.rate_unit if own else ""),
                "momentum": made_of("p_{}", quantity.name),
                "momentum_unit": own.momentum_unit if own else "",
                "q": _number(self.given["q"], flat),
                "v": _number(self.given["v"], flat),
                "q_follows": flat not in self.set_q and self.follow(quantity.name, 0),
                "v_follows": flat not in self.set_v and self.follow(quantity.name, 1),
                "periodic": own is not None and own.unit == "rad",
                "family": item.quantity.name if item.lo is not None else None,
            }

    def states(self) -> Entries:
        """Yields the first-order variables; their indices follow the indices of the rates."""
        known = named.states(self.compilation)
        for flat, *_, quantity in _flat(self.of_rates):
            if quantity.name in known:
                yield {
                    **_named(quantity, flat),
                    "value": _number(self.given["v"], flat),
                    "follows": flat not in self.set_v and self.follow(quantity.name, 0),
                }

    def rotations(self) -> Entries:
        indices = {q.name: k for k, *_, q in _flat(self.of_rates)}
        for r in single_rotations(self.declared):
            found = [indices.get(name) for name in r.rates]
            follows = [self.follow(name, 1) for name in r.turns]
            yield {
                "name": r.name,
                "quaternion": list(r.quaternion),
                "rates": list(r.rates),
                "rate_indices": found,
                "rate_values": [None if k is None else _number(self.given["v"], k) for k in found],
                "rates_follow": [
                    f and k not in self.set_v for f, k in zip(follows, found, strict=True)
                ],
                "rate_unit": r.rate_unit,
                "description": r.description,
            }

    def events(self) -> Entries:
        declared = {event.name: event for event in self.declared.events}
        for k, name in enumerate(named.events(self.compilation)):
            own = declared[name]
            yield {
                **_named(Quantity(name, own.unit, own.description), k),
                "direction": own.direction,
                "stop": own.stop,
                "hidden": hidden(name),
            }

    def methods(self) -> Entries:
        """Yields the model's own methods, then those of the runtime and GSL, with the reason why a
        method does not apply."""
        own = self.compilation.model.methods
        all_methods = known(own)
        made = self.compilation.equations, self.compilation.structure
        default = default_method(made, self.settings.rtol, exact=False)
        for item in [*own_methods(own), *runtime_methods()]:
            name = str(item["name"])
            why = _why_not(self.compilation, all_methods.get(name), item)
            yield {
                "name": name,
                "order": item["order"] or None,
                "stages": item["stages"] or None,
                **{flag: flag in item["flags"] for flag in ("adaptive", "exact", "symplectic")},
                "own": name in {method.name for method in own},
                "gsl": name.startswith("gsl_"),
                "applies": not why,
                "why": why,
                "default": name == default,
                "doc": item["doc"],
            }


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


def _number(row: list[float], k: int) -> float | None:
    return row[k] if k < len(row) and math.isfinite(row[k]) else None


def _following(model: Model) -> Callable[[str, int], bool]:
    """Returns a function of (name, order). It says whether the start of a coordinate (order 0) or
    of its rate (order 1) depends on parameters. If several statements set a start, the last one
    counts."""
    moving = {p.name for p in model.parameters}
    for item in model.definitions:
        if names(item.value) & moving:
            moving.add(item.name)
    found: dict[tuple[str, int | None, int], bool] = {}
    for item in model.starts:
        for index in members_of(model, item):
            found[item.name, index, item.order] = bool(names(item.value) & moving)
    return lambda name, order: found.get((*parted(name), order), False)


# For a flag of a method: the kernels that the method needs, and that models compiled to loops do
# not have. The runtime refuses such a method too.
_NOT_OF_LOOPS = {"holonomic": "M", "jacobians": "Jacobians"}


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
    model = compilation.declared
    if model.noises and "noise" not in item["flags"]:
        return "it takes no noise"
    at_times = [x.name for x in (*model.contacts, *model.frictions, *model.modes)]
    if "holonomic" in item["flags"] and at_times:
        return f"it takes no constraints that hold at times, such as {at_times[0]}"
    if "linear" in item["flags"] and compilation.equations.linear is None:
        return "it needs the derivatives of the acceleration, which so many coordinates are without"
    if "jets" in item["flags"] and not compilation.program.jet:
        return "its Taylor coefficients are compiled only for a scene or an option that names it"
    if not compilation.equations.dense:
        for flag, kernels in _NOT_OF_LOOPS.items():
            if flag in item["flags"]:
                return f"it needs {kernels}, which families that are kept as loops do not have"
    return ""
