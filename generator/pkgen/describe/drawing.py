"""Drawings of a model, from its `draw` statements. A model without `draw` is drawn as bobs at the
positions that it names, or else as graphs of its coordinates over time.

Each number of a drawing is a constant, or a hidden output that is added to the model.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from fractions import Fraction

from .. import limits
from ..compiler import Compilation
from ..graph.graph import Op
from ..indices import in_parts, indexed
from ..middle.particles.bodies import keys, lengths, places
from ..middle.quantities import ends
from ..model import Definition, Drawing, Model
from ..plan import Use
from ..run import named
from ..source import Span
from ..tree import (
    AXES,
    Add,
    Component,
    Expr,
    Multiply,
    Name,
    Number,
    Range,
    Vector,
    names,
    of_member,
)

# A constant number, or {"output": index} for a number that depends on the state.
Entry = float | dict[str, int]
# Names in models do not begin with a digit, so no output of a model has this prefix.
PREFIX = "0_draw_"


def drawn(use: Use | None) -> Use:
    """Returns the transformation `use` of models, extended so that the transformed model also has
    hidden outputs for all nonconstant numbers of its drawing. None stands for the identity."""

    def with_drawing(model: Model) -> Model:
        return replace(model, observed=(*model.observed, *_Outputs(model).all()))

    return replace(use or Use(), more_declared=with_drawing)


def drawing(compilation: Compilation) -> dict[str, object]:
    """Returns the view and the shapes, with indices of outputs of the model from drawn()."""
    model = compilation.declared
    entries = _entries(compilation)
    coordinates = named.coordinates(compilation)
    shapes = []
    outputs = _Outputs(model)
    for item in _drawings(model):
        for shape in outputs.shapes(item):
            if item.shape == "level":
                if not all(name in coordinates for name in item.axes):
                    continue  # Contours need two coordinates, and the scene fixes one of them.
                x, y = (coordinates[name][0] for name in item.axes)
                shape |= {"x": x, "y": y}
            shapes.append(_resolved(shape, entries))
    if not shapes:
        columns = [coordinates[name][0] for name in coordinates]
        shapes.append({"kind": "graph", "columns": columns[: limits.DRAWN]})
    view = _view(model, outputs, entries, shapes)
    return {"view": view, "default": not model.drawings, "shapes": shapes}


def _entries(compilation: Compilation) -> dict[str, Entry]:
    """Maps names of outputs to {"output": index}, or to their value if it is a constant."""
    found: dict[str, Entry] = {}
    for k, quantity in enumerate(named.observed(compilation)):
        found[quantity.name] = {"output": k}
    e = compilation.equations
    for name, node in e.single_outputs.items():
        if e.graph.op[node] is Op.NUMBER:
            found[name] = float(e.graph.data[node])
    return found


def shown(model: Model) -> tuple[str, ...]:
    """Returns lines of text that describe the drawing."""
    if model.drawings:
        return tuple(model.source.written(item.span) for item in model.drawings)
    found = [item.name for item in _defaults(model)]
    if found:
        return (f"places that it names, as bobs: {', '.join(found)}",)
    return ("its coordinates over time: it names no place in a plane or in space",)


def _drawings(model: Model) -> tuple[Drawing, ...]:
    return model.drawings or _defaults(model)


def _defaults(model: Model) -> tuple[Drawing, ...]:
    """Returns a bob at each position that definitions, coordinates and outputs name: vectors, and
    groups of scalars that `middle.particles` recognizes as positions."""
    known = lengths(model)
    items: list[tuple[Name, tuple]] = []
    vectors: dict[tuple, dict[str, Span]] = {}
    found: dict[str, Drawing] = {}
    for item in (*model.coordinates, *model.definitions, *model.observed):
        if item.name not in known or item.name[0].isdigit() or getattr(item, "rate", ""):
            continue
        stem, part = in_parts(item.name)
        if stem in model.source.parts:
            stem, part = item.name, ""
        if part and part not in AXES:  # the body's centre of mass is drawn, not its components
            if part == "com":
                whole = Name(item.name, None, item.span)
                at = tuple(Component(whole, k, item.span) for k in range(3))
                found[stem] = _bob(stem, at, item.span)
            continue
        for index in _members(model, item):
            if part or isinstance(getattr(item, "value", None), Vector):
                vectors.setdefault((stem, index), {})[part] = item.span
            else:
                name = Name(item.name, _place(index, item.span), item.span)
                items.append((name, tuple(keys(item.name, index))))
    for (name, index), parts in vectors.items():
        *_, span = parts.values()
        at = _place(index, span)
        whole = Name(name, at, span)
        by_axis = tuple(
            Name(f"{name}.{axis}", at, span) if axis in parts else Component(whole, k, span)
            for k, axis in enumerate(AXES)
        )
        found[indexed(name, index)] = _bob(indexed(name, index), by_axis, span)
    for group in places(items):
        shown = ", ".join(_written(group[axis]) for axis in sorted(group))
        at = tuple(group.get(axis, Number(Fraction(0), model.span)) for axis in range(3))
        if not any(_written(part) in other for other in found for part in group.values()):
            found[f"({shown})"] = _bob(f"({shown})", at, model.span)
    return tuple(found.values())[: limits.DRAWN]


def _place(index: int | None, span: Span) -> Number | None:
    return None if index is None else Number(Fraction(index), span)


def _written(name: Name) -> str:
    return name.id if name.index is None else f"{name.id}[{name.index.value}]"


def _bob(name: str, at: tuple[Expr, ...], span: Span) -> Drawing:
    return Drawing("bob", (("at", at),), None, name, "", span)


def _members(model: Model, item: object) -> Iterator[int | None]:
    family = getattr(item, "range", None)
    if family is None:
        yield None
        return
    lo, hi = ends(model, family)
    yield from range(lo, min(hi, lo + limits.DRAWN - 1) + 1)


class _Outputs:
    """The hidden outputs of a drawing: each distinct expression once, in order of occurrence."""

    def __init__(self, model: Model):
        self.model = model
        self.names: dict[object, str] = {}
        self.definitions: list[Definition] = []

    def all(self) -> list[Definition]:
        for item in (*_drawings(self.model), *self.model.views):
            list(self.shapes(item))
        return self.definitions

    def shapes(self, item: Drawing) -> Iterator[dict[str, object]]:
        """Yields the shapes that a `draw` statement makes. A statement about a family makes one
        shape per member, but a curve through all members is a single shape."""
        made = [self._shape(item, parts) for parts in self._of_members(item)]
        if item.shape == "curve":
            made = [{"kind": "curve", "points": [s["at"] for s in made], **_labels(item)}]
        elif item.range is not None and item.shape != "trail":
            for shape, index in zip(made, self._indices(item.range), strict=True):
                shape["member"] = index
        if caption := _caption(self.model, item):
            made[:1] = [{**shape, "caption": caption} for shape in made[:1]]
        if times := _times(self.model, item):
            made = [{**shape, "times": times} for shape in made]
        yield from made

    def _of_members(self, item: Drawing) -> Iterator[dict[str, tuple[Expr, ...]]]:
        if (of := item.range) is None:
            yield dict(item.parts)
            return
        for value in self._indices(of):
            index = self._index(of, value, ends(self.model, of)[1] - value)
            yield {
                word: tuple(of_member(x, of.variable, index) for x in found)
                for word, found in item.parts
            }

    def _indices(self, family: Range) -> range:
        """Returns the indices of the drawn members, evenly spaced, at most limits.DRAWN."""
        lo, hi = ends(self.model, family)
        return range(lo, hi + 1, max(1, -(-(hi + 1 - lo) // limits.DRAWN)))

    def _index(self, range: Range, value: int, behind: int) -> Expr:
        """Returns the index of a member as an expression. In the second half of a family, the
        expression counts from the end, like N - 1, so that the family can be compiled to loops;
        `behind` is the distance from the end."""
        if behind >= value or not names(range.hi):
            return Number(Fraction(value), range.span)
        return Add((range.hi, Number(Fraction(behind), range.span)), (1, -1), range.span)

    def _shape(self, item: Drawing, parts: dict[str, tuple[Expr, ...]]) -> dict[str, object]:
        made = {"kind": item.shape, **_labels(item), **_MORE.get(item.shape, {})}
        for word, found in parts.items():
            entries = [self._entry(x, item.span) for x in found]
            made[word] = entries[0] if len(entries) == 1 and word != "sizes" else entries
        if item.shape == "arrow" and not item.description and self.model.drawings:
            made["says"] = _said(self.model, dict(item.parts)["vector"])
        if item.shape == "body":
            made["form"] = item.form
        if item.shape == "ground":
            made["axis"] = item.axes[0]
        return made

    def _entry(self, expr: Expr, span: Span) -> str | float:
        if isinstance(expr, Number):
            return float(expr.value)
        key = _key(expr)
        if key not in self.names:
            name = self.names[key] = f"{PREFIX}{len(self.names)}"
            self.definitions.append(Definition(name, None, None, expr, "", "", span))
        return self.names[key]


# Parts of shapes that statements may leave out.
_MORE: dict[str, dict[str, object]] = {
    "body": {"turn": None},
    "bob": {"radius": None},
    "circle": {"normal": [0.0, 0.0, 1.0]},
}
# Keys of a shape whose values are not outputs.
_WORDS = ("kind", "name", "label", "form", "axis", "caption", "says", "times", "member")


def _caption(model: Model, item: Drawing) -> str:
    """Returns the text of the comment in the line above a `draw` statement, which is the caption of
    its shape. Returns "" for the first `draw` statement, since the comment above it is the title of
    the whole drawing."""
    if item in model.drawings[:1] or not model.drawings:
        return ""
    above = model.source.text[: item.span.start].rpartition("\n")[0].rpartition("\n")[2].strip()
    return above[1:].strip().rstrip(".") if above.startswith("#") else ""


def _times(model: Model, item: Drawing) -> float | None:
    """Returns the factor by which the drawing magnifies a coordinate, such as 20 in `at 20*x`; None
    if there is none."""
    coordinates = {c.name for c in model.coordinates}
    for part in dict(item.parts).get("at", ()) if item.shape in ("bob", "curve") else ():
        if isinstance(part, Multiply) and part.exponents == (1, 1):
            factor, of = part.factors
            if isinstance(factor, Number) and isinstance(of, Name) and of.id in coordinates:
                return float(factor.value)
    return None


def _said(model: Model, parts: tuple[Expr, ...]) -> str:
    """Returns the label of an arrow whose statement has no comment: "velocity" if its vector
    consists of rates, otherwise the text of its vector."""
    text = model.source.written(parts[0].span.to(parts[-1].span))
    return "velocity" if re.fullmatch(r"\[\w+'(, (\w+'|0))*\]|\w+'|\[0, \w+', 0\]", text) else text


def _labels(item: Drawing) -> dict[str, object]:
    found = {"name": item.name, "label": item.description}
    return {key: value for key, value in found.items() if value}


def _key(part: object) -> object:
    """Returns a hashable key of an expression, the same wherever it is in the text."""
    if isinstance(part, tuple):
        return tuple(map(_key, part))
    if is_dataclass(part):
        own = (f.name for f in fields(part) if not f.name.endswith("span"))
        return (type(part).__name__, *(_key(getattr(part, name)) for name in own))
    return part


def _resolved(part: object, entries: dict[str, Entry]) -> object:
    if isinstance(part, dict):
        return {k: v if k in _WORDS else _resolved(v, entries) for k, v in part.items()}
    if isinstance(part, list):
        return [_resolved(x, entries) for x in part]
    return entries[part] if isinstance(part, str) else part


def _view(
    model: Model, outputs: _Outputs, entries: dict[str, Entry], shapes: list
) -> dict[str, object]:
    if model.views:
        (item,) = model.views
        (shape,) = outputs.shapes(item)
        width = _resolved(shape.get("width"), entries)
        axes = {"axes": list(item.axes)} if item.shape == "plane" else {}
        return {"kind": item.shape, **axes, "width": width}
    if any(map(_spatial, shapes)):
        return {"kind": "space", "width": None}
    return {"kind": "plane", "axes": ["x", "y"], "width": None}


def _spatial(shape: dict) -> bool:
    """Whether any part of a shape may leave the xy plane."""
    places = [shape.get(word) for word in ("at", "from", "to")]
    points = [at for at in places if isinstance(at, list) and len(at) == 3]
    points += shape.get("points", [])
    turn = shape.get("turn")
    tilted = turn is not None and any(turn[k] != 0.0 for k in (2, 5, 6, 7))
    return tilted or shape.get("axis") == "z" or any(point[2] != 0.0 for point in points)
