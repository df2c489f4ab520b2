"""Specialises a model to a scene (a run's settings), before the equations are derived: parameters
that the scene sets become constants, and coordinates that it holds follow a prescribed motion.

A parameter becomes a constant definition, so that its number is compiled into the C code. A held
coordinate becomes a definition of its motion as a function of t; if it is the first or last member
of a family, the family gets a fixed end instead.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from ..indices import integer, of_made
from ..model import Coordinate, Definition, End, Force, Hold, Model, Rate, Scene, Start, State
from ..tree import Add, Expr, Name, Number, names, of_member, within
from .quantities import Family, ends, error, families, indexed, sizes
from .report import ReportLine


def folded(model: Model, scene: Scene, run_time: frozenset[str]) -> tuple[Model, list[ReportLine]]:
    """Returns the model in which parameters set by the scene are constants, and report lines.
    Parameters in `run_time` are left out, since they are set again at run time."""
    parameters = {p.name: p for p in model.parameters}
    fixed: dict[str, Definition] = {}
    for k, item in enumerate(scene.assignments):
        parameter = parameters.get(item.name)
        if parameter is None or item.name in run_time:
            continue
        if parameter.range is not None or item.index is not None:
            continue  # parameters with an index stay in an array
        if names(item.value) & {later.name for later in scene.assignments[k:]}:
            # A later assignment changes a parameter in this expression, so that the value of the
            # expression is known only at run time.
            continue
        fixed[item.name] = Definition(
            item.name, None, None, item.value, parameter.unit, parameter.description, item.span
        )
    if not fixed:
        return model, []
    used = with_definitions(model, list(fixed.values()))
    kept = tuple(p for p in model.parameters if p.name not in fixed)
    lines = [ReportLine(", ".join(fixed), "fixed by the scene, so a number in the C")]
    return replace(used, parameters=kept), lines


def held(
    model: Model, scene: Scene, asked_events: frozenset[str] = frozenset()
) -> tuple[Model, list[ReportLine]]:
    """Returns the model without the coordinates that the scene holds, and report lines. If any are
    held, events are left out unless they are requested or stop the run. Raises ModelError for a
    coordinate that cannot be held."""
    lines = []
    if scene.holds and model.conserved:
        claimed = ", ".join(item.name for item in model.conserved)
        lines.append(ReportLine(claimed, "claimed of the free motion, not of this one"))
        model = replace(model, conserved=())
    # A constant event would be an error. Events on held coordinates may become constant: limits of
    # held coordinates, and events that nothing requests, are left out.
    if scene.holds:
        held = {_member(item, model) for item in scene.holds}
        gone = {e.name for e in model.events if e.limit and held & _members(e.value, model)}
        lines += [ReportLine(name, "a limit of what is held") for name in sorted(gone)]
        asked = asked_events | {e.name for e in model.events if e.stop and e.name not in gone}
        kept = tuple(e for e in model.events if e.name in asked)
        model = replace(model, events=kept)
    for item in scene.holds:
        index, value = _motion(model, item)
        _refuse_momentum(model, scene, item.name, index)
        model = _without(model, item, index, value)
        name = indexed(item.name, index)
        lines.append(ReportLine(name, "its motion is given, so it has no equation"))
    if scene.holds and not model.coordinates:
        _refuse_energy(model, scene)
    return model, lines


def _member(of: Hold | Start | Rate | Force | Name, model: Model) -> tuple[str, int | None]:
    name = of.id if isinstance(of, Name) else of.name
    return name, None if of.index is None else integer(of.index, sizes(model))


def _members(value: Expr, model: Model) -> set[tuple[str, int | None]]:
    """Returns a pair (name, index) for each name in an expression. The expression must not contain
    loop variables."""
    return {_member(part, model) for part in within(value) if isinstance(part, Name)}


def _refuse_momentum(model: Model, scene: Scene, name: str, index: int | None) -> None:
    """Raises ModelError if the scene uses the momentum of a held coordinate: it has none."""
    known = sizes(model)
    for part in _asked(scene):
        if (
            not isinstance(part, Name)
            or of_made("p_", part.id) != name
            or names(part) - {*known, part.id}
        ):
            continue  # an index with a loop variable is checked when the sum is expanded
        if (None if part.index is None else integer(part.index, known)) == index:
            momentum, held = indexed(part.id, index), indexed(name, index)
            message = f"'{momentum}': {held} is held here, and has no momentum"
            raise error(model, message, part.span, f"'{held}' and its rate can be recorded")


def _refuse_energy(model: Model, scene: Scene) -> None:
    """Raises ModelError if the scene uses the energy: a model of states alone has none."""
    for part in _asked(scene):
        if isinstance(part, Name) and part.id in ("energy", "V_eff"):
            message = "there is no energy here: every coordinate is held, and states have none"
            raise error(model, message, part.span, "'T', 'V' and 'L' are known as functions of t")


def _asked(scene: Scene) -> Iterator[Expr]:
    """Yields all expressions that a scene records or expects, with their subexpressions."""
    asked = [column.value for column in scene.record.columns] if scene.record else []
    asked += [side for item in scene.expects for side in (item.a, item.b)]
    return (part for expr in asked for part in within(expr))


def _motion(model: Model, item: Hold) -> tuple[int | None, Expr]:
    """Returns the index of the held coordinate in its family, and its motion as an expression."""
    if item.range is not None:
        raise error(
            model,
            f"the whole of '{item.name}' cannot be held",
            item.span,
            "hold its first or last members, one by one, or leave the family out of the model",
        )
    index = None if item.index is None else integer(item.index, sizes(model))
    return index, item.value if item.value is not None else _start(model, item, index)


def _start(model: Model, item: Hold, index: int | None) -> Expr:
    """Returns the initial value of the coordinate that `item` holds. If several statements set it,
    the last one counts; if none does, it is 0."""
    found: Expr = Number(Fraction(0), item.span)
    for start in model.starts:
        if start.order:
            continue
        if _is_of(model, start, item, index):
            found = start.value
        elif start.name == item.name and start.range is not None:
            lo, hi = ends(model, start.range)
            if lo <= index <= hi:
                found = of_member(
                    start.value, start.range.variable, Number(Fraction(index), item.span)
                )
    return found


def _without(model: Model, item: Hold, index: int | None, value: Expr) -> Model:
    field = "states" if any(x.name == item.name for x in model.states) else "coordinates"
    moving = getattr(model, field)
    found = families(model, moving)
    family = found.get(item.name)
    if family is None or not family.has(index):
        what = field.removesuffix("s")
        raise error(model, f"no {what} '{indexed(item.name, index)}' is left", item.span)
    declared = next(c for c in moving if c.name == item.name)
    if family.lo is None:
        gone = Definition(
            item.name, None, None, value, declared.unit, declared.description, item.span
        )
        model = with_definitions(model, [gone])
        moving = tuple(c for c in moving if c is not declared)
    else:
        model, shorter = _shorter(model, item, family, declared, index, value)
        moving = tuple(shorter if c is declared else c for c in moving)
    return replace(
        model,
        **{field: moving},
        **{
            name: tuple(x for x in getattr(model, name) if not _is_of(model, x, item, index))
            for name in _OF_MEMBERS
        },
    )


_OF_MEMBERS = ("rates", "starts", "forces", "noises")  # fields of Model: statements about members


def _is_of(model: Model, of: Start | Rate | Force, item: Hold, index: int | None) -> bool:
    return of.range is None and _member(of, model) == (item.name, index)


def _shorter(
    model: Model, item: Hold, family: Family, declared: Coordinate | State, index: int, value: Expr
) -> tuple[Model, Coordinate | State]:
    """Replaces the first or last member of a family by a fixed end. Returns the model and the
    declaration of the shorter family."""
    if index not in (family.lo, family.hi) or family.count == 1:
        why, help = "none would be left", "leave the family out of the model"
        if family.count > 1:
            lo, hi = (indexed(item.name, end) for end in (family.lo, family.hi))
            why = "it is neither the first nor the last"
            help = f"members are held from an end on, in order: {lo} or {hi} first"
        raise error(model, f"'{indexed(item.name, index)}' cannot be held: {why}", item.span, help)
    if any(end.name == item.name and end.kind == "periodic" for end in model.ends):
        raise error(model, f"'{item.name}' is periodic: it has no end to hold", item.span)
    first = index == family.lo
    at = Number(Fraction(index), item.span)
    fixed = End("fixed", item.name, index, value, item.span, at)
    changed = [end for old in model.ends for end in _ends(old, item, family, fixed)]
    lo, hi = declared.range.lo, declared.range.hi
    one = Number(Fraction(1 if first else -1), item.span)
    moved = Add((lo if first else hi, one), (1, 1), item.span)
    range_ = replace(declared.range, **{"lo" if first else "hi": moved})
    model = replace(
        model,
        ends=(*changed, fixed),
        **{x: _shorter_too(model, getattr(model, x), item, index) for x in _OF_MEMBERS},
    )
    return model, replace(declared, range=range_)


def _ends(old: End, item: Hold, family: Family, fixed: End) -> list[End]:
    """Returns the declaration `old` of an end of a family as declarations with explicit indices.
    Without an index, `old` would refer to the ends of the shorter family. A free end next to the
    held member gets the fixed value of the held member."""
    if old.name != item.name:
        return [old]
    places = [old.index] if old.index is not None else [family.lo - 1, family.hi + 1]
    return [
        replace(
            fixed if old.kind == "free" and abs(place - fixed.index) == 1 else old,
            index=place,
            at=Number(Fraction(place), old.span),
        )
        for place in places
    ]


def _shorter_too(model: Model, items: tuple, item: Hold, index: int) -> tuple:
    """Returns the statements `items` about the shorter family: ranges that begin or end at the held
    member no longer include it."""
    known = sizes(model)
    found = []
    for old in items:
        if old.name == item.name and old.range is not None:
            lo, hi = integer(old.range.lo, known), integer(old.range.hi, known)
            lo, hi = lo + (index == lo), hi - (index == hi)
            if lo > hi:
                continue
            lo, hi = (Number(Fraction(end), old.span) for end in (lo, hi))
            old = replace(old, range=replace(old.range, lo=lo, hi=hi))
        found.append(old)
    return tuple(found)


def with_definitions(model: Model, new: list[Definition]) -> Model:
    """Returns the model with the definitions `new`. They are placed before all old definitions, so
    that these may use them, except for old definitions that the new ones use: these come first."""
    wanted = frozenset().union(*(names(item.value) for item in new))
    first: list[Definition] = []
    for item in reversed(model.definitions):
        if item.name in wanted:
            wanted |= names(item.value)
            first.insert(0, item)
    rest = (item for item in model.definitions if item not in first)
    return replace(model, definitions=(*first, *new, *rest))
