"""Applies a scene to its model before compilation: starts, inputs that depend on t, outputs.

Outputs that only expectations use are hidden: their names begin with a digit, which no name in a
model does, and they are not columns of the rows.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace
from fractions import Fraction

from ..front.check.options_text import LeftSide, OptionError, left_side
from ..indices import indexed, integer, made_of, multipliers, of_made, parted
from ..middle.quantities import ends, sizes
from ..middle.specialise import with_definitions
from ..model import Constraint, Coordinate, Definition, Load, Model, Record, Scene, State
from ..tree import AXES, Call, Expr, Name, Number, Prime, names, of_member, replaced
from . import expects


def used(model: Model, scene: Scene, given: Collection[str] = ()) -> Model:
    """Returns the model with the scene's starts, its inputs that are functions of t, and additional
    outputs for its columns. Inputs in `given` are set by options instead."""
    held = _held(model, scene)
    extra: dict[str, Definition] = {}

    def has(name: str) -> bool:
        return name in extra or (_is_column(model, name) and name.removesuffix("'") not in held)

    for item in scene.record.columns if scene.record else ():
        if not has(item.name):
            extra[item.name] = item
    for name, (value, span) in expects.outputs(scene, has).items():
        extra[name] = Definition(name, None, None, value, "", "", span)
    outputs = (replace(item, value=_claims(model, item.value)) for item in extra.values())
    starts, swarm = scene.starts, scene.swarm
    if swarm is not None:  # those of its first member
        first = (of_member(start.value, swarm.variable, swarm.lo) for start in starts)
        starts = [replace(start, value=x) for start, x in zip(starts, first, strict=True)]
    return replace(
        _driven(model, scene, given),
        starts=(*model.starts, *starts),
        observed=(*model.observed, *outputs),
        consistent=model.consistent or scene.consistent,
    )


def written_out(
    model: Model, columns: Iterable[str], scene: Scene | None = None
) -> tuple[str, ...]:
    """Returns the names of columns, with vectors and rotations replaced by their components."""
    recorded = scene.record.columns if scene is not None and scene.record else ()
    known = {item.name.rstrip("'") for item in (*model.observed, *model.conserved, *recorded)}
    known |= {parted(item.name.rstrip("'"))[0] for item in recorded}
    known |= {name for item in model.constraints for name in multipliers(item.name)}
    known |= {name for r in model.rotations for name in (*r.rates, *r.momenta)}
    quaternions = {r.name: r.quaternion for r in model.rotations}
    found: list[str] = []
    for text in columns:
        try:
            side = left_side(text, sizes(model))
        except OptionError:
            found.append(text)  # The look-up of the run's columns reports an invalid name.
            continue
        if side.name in quaternions and not side.order:
            found += (replace(side, name=name).text() for name in quaternions[side.name])
            continue
        parts = [f"{side.name}.{axis}" for axis in AXES]
        whole = side.name in known or not known.issuperset(parts)
        found += [replace(side, name=name).text() for name in ([side.name] if whole else parts)]
    return tuple(found)


def recording(model: Model, scene: Scene, columns: Iterable[str]) -> Scene:
    """Returns the scene with these recorded columns. Invalid names are left out; the look-up of the
    run's columns reports them later."""
    held = _held(model, scene)
    own = {item.name: item for item in (scene.record.columns if scene.record else ())}
    found: list[Definition] = []
    for text in columns:
        if text in own:
            found.append(own[text])
            continue
        try:
            side = left_side(text, sizes(model))
        except OptionError:
            continue
        unit = _unit(model, side)
        name = indexed(side.name, side.index)
        if unit is None or of_made("p_", name) in held:
            continue
        index = None if side.index is None else Number(Fraction(side.index), scene.span)
        value = _power(model, side) or Name(side.name, index, scene.span)
        for _ in range(side.order):
            value = Prime(value, scene.span)
        name += "'" * side.order
        found.append(Definition(name, None, None, value, unit, "", scene.span))
    record = scene.record or Record((), None, "", scene.span)
    return replace(scene, record=replace(record, columns=tuple(found)))


def _power(model: Model, side: LeftSide) -> Expr | None:
    """Returns the power of a force if it is meant by `power(NAME)`, else None."""
    for item in model.loads:
        if side.name == f"power({item.name})":
            value = Call("dot", (item.value, item.velocity), item.span)
            if item.range is None:
                return value
            return of_member(value, item.range.variable, Number(Fraction(side.index), item.span))
    return None


def _unit(model: Model, side: LeftSide) -> str | None:
    """Returns the unit of a quantity that can be recorded but is no output, else None."""
    declared = {item.name for item in model.parameters}
    if side.text() in {"L", "T", "V", "V_eff"} - declared:
        return "" if model.dimensionless else "J"
    own = side.name, side.order
    for item in (
        *model.coordinates,
        *model.states,
        *model.conserved,
        *model.constraints,
        *model.loads,
    ):
        match item:
            case Coordinate(rate=rate) if rate:
                units = {(rate, 0): item.rate_unit, (item.momentum, 0): item.momentum_unit}
            case Coordinate() | State():
                units = {(item.name, 0): item.unit, (item.name, 1): item.rate_unit}
                if isinstance(item, Coordinate):
                    units[made_of("p_{}", item.name), 0] = item.momentum_unit
            case Constraint(name=name):
                units = {(found, 0): item.unit for found in multipliers(name)}
            case Definition(name=name):
                units = {(name, 0): item.unit}
            case Load(name=name):
                units = {(f"power({name})", 0): "" if model.dimensionless else "W"}
        if own in units and _has(model, item, side.index):
            return units[own]
    return None


def _has(
    model: Model, item: Coordinate | State | Definition | Constraint | Load, index: int | None
) -> bool:
    if item.range is not None:
        lo, hi = ends(model, item.range)
        return index is not None and lo <= index <= hi
    own = item.index if isinstance(item, Definition | Constraint) else None
    return index == (None if own is None else integer(own, sizes(model)))


def of_swarm(scene: Scene, value: Expr) -> bool:
    """Whether `value`, the value of a start statement, differs between members of the swarm."""
    return scene.swarm is not None and scene.swarm.variable in names(value)


def reads(model: Model, scene: Scene) -> frozenset[str]:
    """Returns the names that occur in the scene's settings, directly or in definitions."""
    asked = [scene.until, scene.step, scene.rtol, scene.record.every if scene.record else None]
    asked += [item.value for item in (*scene.assignments, *scene.starts)]
    asked += [x for item in scene.expects for x in (item.a, item.b, item.within, item.at)]
    found = {name for expr in asked if expr is not None for name in names(expr)}
    for item in reversed(model.definitions):
        if item.name in found:
            found |= names(item.value)
    return frozenset(found)


def columns(scene: Scene) -> list[str]:
    """Returns the names of the columns that the scene records; [] if it does not choose any."""
    return [item.name for item in scene.record.columns] if scene.record else []


def needed(scene: Scene) -> frozenset[str]:
    """Returns the columns that expectations need, also constants of motion whose drift they use."""
    return frozenset(expects.outputs(scene)) | expects.columns(scene) | expects.drifting(scene)


def _held(model: Model, scene: Scene) -> set[str]:
    """Returns the coordinates whose motion the scene prescribes; they are recorded as outputs."""
    known = sizes(model)
    return {
        indexed(item.name, None if item.index is None else integer(item.index, known))
        for item in scene.holds
    }


def _is_column(model: Model, name: str) -> bool:
    """Whether `name` is a column of every run. If a family x[1..n] has members x[0] and x[n+1] with
    a prescribed motion, these are not columns."""
    once = name.removesuffix("'")
    base, index = parted(once)
    if any(item.rate and name == item.rate for item in model.coordinates):
        return True
    for item in model.coordinates:
        if item.name == base:
            return "'" not in once and _has(model, item, index)
    for item in model.states:  # the rate x' of a state x is an output
        if item.name == base:
            return "'" not in name and _has(model, item, index)
    return name == once and base in {"energy", *(o.name for o in model.observed)}


def _claims(model: Model, value: Expr) -> Expr:
    """Returns the expression with the model's claimed constants of motion, which are no outputs,
    replaced by their definitions."""
    claims = {item.name: item for item in model.conserved}

    def written(part: Expr) -> Expr | None:
        claim = claims.get(part.id) if isinstance(part, Name) else None
        if claim is None:
            return None
        body = claim.value
        if claim.range is not None:
            body = of_member(body, claim.range.variable, part.index)
        return replaced(body, written)

    return replaced(value, written)


def _driven(model: Model, scene: Scene, given: Collection[str]) -> Model:
    """Replaces inputs that are functions of t by definitions, which have time derivatives."""
    values = {item.name: item for item in scene.assignments if item.name not in given}
    driven = [(x, values[x.name]) for x in model.inputs if x.name in values]
    lets = [
        Definition(x.name, None, None, by.value, x.units[0], x.description, by.span)
        for x, by in driven
    ]
    kept = tuple(x for x in model.inputs if x.name not in values)
    return with_definitions(replace(model, inputs=kept), lets) if lets else model
