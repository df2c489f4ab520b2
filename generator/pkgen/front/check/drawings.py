"""Checks `draw` and `view`. All positions in a drawing have the dimension of the first one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ... import model as m
from ...source import Span
from ...system.near import meant
from ...tree import AXES, Expr, Multiply, Name, Range, Vector
from .. import shapes
from .. import statements as st
from ..units import LENGTH, NONE, Dimension, described, over, si_text
from .expr import Target
from .scope import PLACES, Scope
from .shared import Checks, Shared
from .vectors import UNIT, applied, component
from .written import written


class Drawings(Checks):
    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self.length: Dimension | None = None  # Dimension of the first position.
        self.first = 0  # Source line of the first position.

    def draw(self, statement: st.Draw) -> None:
        scope: Scope | None = Scope(PLACES["drawing"])
        statement = self._of_body(statement)
        members = statement.also if isinstance(statement.also, Range) else None
        if members is not None:
            scope = self.indices.enter((members,), scope)
        if scope is None or not self._fits(statement):
            return
        shape, subject = shapes.SHAPES[statement.shape], statement.subject
        given = {word: value for word, _, value in statement.parts}
        parts: list[tuple[str, tuple[Expr, ...]]] = []
        axes: tuple[str, ...] = ()
        if shape.subject == shapes.AXIS:
            axes = (statement.axis,)
            parts.append(("at", self._number(subject, scope, "a ground", self._lengths())))
        elif shape.subject == shapes.VALUE:
            axes = self._coordinates(statement)
            parts.append(("value", self._level(subject, scope, axes)))
        elif shape.subject == shapes.ROTATION:
            parts.append(("turn", self._turn(subject, scope)))
        elif shape.subject == shapes.PLACE:
            parts.append(("at", self._place(subject, scope)))
        elif shape.subject == shapes.VECTOR:
            parts.append(("vector", self._arrow(subject, given["scale"], scope)))
        for word, value in given.items():
            what, name = shape.parts[word], "sizes" if word in shapes.FORMS else word
            parts.append((name, self._part(what, word, value, scope)))
        form = next((word for word in given if word in shapes.FORMS), "")
        name = subject.id if isinstance(subject, Name) else ""
        self._add("drawings", statement, parts, axes, members, name, form)

    def _of_body(self, statement: st.Draw) -> st.Draw:
        """Completes `draw body upper box [..]` for a body `upper`: adds its rotation upper.R and,
        without `at`, its centre of mass as position."""
        name = statement.subject.id if isinstance(statement.subject, Name) else ""
        entry = self.names.table.get(name)
        if statement.shape != "body" or entry is None or entry.kind != "body":
            return statement
        turn, com = (replace(statement.subject, id=f"{name}.{which}") for which in ("R", "com"))
        at = () if any(word == "at" for word, *_ in statement.parts) else (("at", com.span, com),)
        return replace(statement, subject=turn, parts=(*at, *statement.parts))

    def _part(self, what: str, word: str, value: Expr, scope: Scope) -> tuple[Expr, ...]:
        """Checks a clause of a drawing and returns its expressions. Returns () for the clauses
        `scale` and `in`, which are checked together with the subject of the drawing."""
        if what == shapes.PLACE:
            return self._place(value, scope)
        if word in shapes.FORMS:
            return self._sizes(word, value, scope)
        if what == shapes.LENGTH:
            target = self._lengths(f"a {word} is a length")
            return self._number(value, scope, f"a {word}", target)
        if what == shapes.TIME:
            time = self.time_dimension
            return self._constant(value, scope, Target(time, f"'{word}' needs a time", bare=True))
        if what == shapes.COUNT:
            return self._constant(value, scope, Target(NONE, f"'{word}' needs a number"))
        return ()

    def _add(
        self,
        field: str,
        statement: st.Draw,
        parts: Iterable[tuple[str, tuple[Expr, ...]]],
        axes: tuple[str, ...],
        members: Range | None = None,
        name: str = "",
        form: str = "",
    ) -> None:
        found = tuple((word, exprs) for word, exprs in parts if exprs)
        said = name, statement.description, statement.span, form, axes
        self.parts[field].append(m.Drawing(statement.shape, found, members, *said))

    def view(self, statement: st.Draw) -> None:
        if self.parts["views"]:
            self.error("a model has one 'view'; this is the second", statement)
            return
        if not self._fits(statement):
            return
        axes: tuple[str, ...] = tuple(AXES)
        if statement.shape == "plane":
            subject = statement.subject
            named = subject.id if isinstance(subject, Name) and subject.index is None else ""
            if named not in shapes.PLANES:
                message = f"there is no such plane: it is {' or '.join(shapes.PLANES)}"
                self.error(message, subject, f"e.g. {shapes.SHAPES['plane'].form}")
                return
            axes = shapes.PLANES[named]
        scope, target = Scope(PLACES["drawing"]), self._lengths("a width is a length")
        parts = [
            (word, self._number(value, scope, "a width", target))
            for word, _, value in statement.parts
        ]
        self._add("views", statement, parts, axes)

    def _fits(self, statement: st.Draw) -> bool:
        """Whether a drawing has the subject and clauses that its shape needs; reports errors."""
        name, shape = statement.shape, shapes.SHAPES[statement.shape]
        before = self.report.count
        form = f"the form is: {shape.form}"
        if bool(statement.axis) != (shape.subject == shapes.AXIS):
            message = f"'{name}' takes {'AXIS = VALUE' if shape.subject == shapes.AXIS else 'no ='}"
            self.error(message, statement, form)
        elif statement.axis and statement.axis not in AXES:
            self.error(f"there is no axis '{statement.axis}': it is x, y or z", statement, form)
        if (statement.subject is None) and shape.subject and not shape.subject_optional:
            needed = _NEEDED.get(shape.subject, f"a {shape.subject}")
            self.error(f"'{name}' needs {needed}", statement.shape_span, form)
        if statement.subject is not None and not shape.subject:
            self.error(f"'{name}' takes its parts alone", statement.subject, form)
        seen: set[str] = set()
        for word, span, _ in statement.parts:
            if word not in shape.parts:
                have = ", ".join(f"'{part}'" for part in shape.parts)
                help = meant(word, shape.parts) or (f"it has {have}" if have else form)
                self.error(f"'{name}' has no part '{word}'", span, help)
            elif word in seen:
                self.error(f"'{word}' is given twice", span)
            seen.add(word)
        missing = [p for p in shape.parts if p not in seen and p not in shape.optional]
        if missing and self.report.count == before:
            words = " and ".join(f"'{word}'" for word in missing)
            self.error(f"'{name}' needs {words}", _end(statement.span), form)
        bodies = [(word, span) for word, span, _ in statement.parts if word in shapes.FORMS]
        if name == "body" and len(bodies) != 1 and self.report.count == before:
            self.error(
                "a body is one of: " + ", ".join(shapes.FORMS),
                bodies[1][1] if bodies else _end(statement.span),
                form,
            )
        if statement.also is not None and name in ("ground", "plane", "space"):
            self.error(f"'{name}' has no members", statement.also, form)
        elif isinstance(statement.also, Expr) and name != "level":
            self.error("behind the comma stands a range", statement.also, "i = 1..N")
        elif name == "level" and not isinstance(statement.also, Expr):
            self.error("a level is over two coordinates", _end(statement.span), form)
        return self.report.count == before

    # values of parts

    def _place(self, value: Expr, scope: Scope) -> tuple[Expr, ...]:
        value = self.origin(value)
        before = self.report.count
        if self.length is None:
            found, facts = self.checked(value, scope)
        else:
            needs = f"a place is {described(self.length)} as the one in line {self.first} is"
            found, facts = self.wanted_vector(value, scope, Target(self.length, needs))
        if not facts.known or self.report.count > before:
            return ()
        if not facts.vector:
            self.error("a place is a vector", value, "write [x, y, 0], or the name of one by 'let'")
            return ()
        if self.length is None and facts.dimension is not None:
            self.length, self.first = facts.dimension, self.names.line_of(value.span)
        self.use_inputs(facts)
        return _components(found)

    def _lengths(self, needs: str = "it is a length") -> Target:
        """Returns the Target of a number that has the dimension of positions."""
        length = self.length
        if length is None and self.time_dimension != NONE:
            length = LENGTH
        shown = "" if length in (None, NONE) else f" [{si_text(length)}]"
        return Target(length, f"{needs}{shown}", bare=True)

    def _number(self, value: Expr, scope: Scope, what: str, target: Target) -> tuple[Expr, ...]:
        found, facts = self.wanted(self.origin(value), scope, target)
        self.use_inputs(facts)
        if facts.known and facts.value is not None and facts.value < 0 and what != "a ground":
            self.error(f"{what} is not negative", value)
        return (found,) if facts.known else ()

    def _constant(self, value: Expr, scope: Scope, target: Target) -> tuple[Expr, ...]:
        before = self.report.count
        found, facts = self.wanted(value, scope, target)
        if self.report.count > before:
            return ()
        if facts.known and facts.value is None:
            self.error("this is a number, not an expression", value)
        elif facts.known and facts.value <= 0:
            self.error("this is a number above 0", value)
        return (found,) if facts.known else ()

    def _arrow(self, vector: Expr, scale: Expr, scope: Scope) -> tuple[Expr, ...]:
        """Returns the components of an arrow, multiplied by its scale."""
        found, facts = self.checked(vector, scope)
        if facts.known and not facts.vector:
            self.error("an arrow shows a vector", vector, "write [x, y, 0], or the name of one")
            return ()
        length = self.length if self.length is not None else self._lengths().dimension
        needed = None
        if None not in (length, facts.dimension):
            needed = over(length, facts.dimension)
        shown = "" if needed in (None, NONE) else f" [{si_text(needed)}]"
        factor, of = self.wanted(
            scale, scope, Target(needed, f"'scale' needs a number{shown}", True)
        )
        self.use_inputs(facts)
        if not (facts.known and of.known):
            return ()
        return tuple(Multiply((factor, part), (1, 1), vector.span) for part in _components(found))

    def _sizes(self, form: str, value: Expr, scope: Scope) -> tuple[Expr, ...]:
        items = value.items if isinstance(value, Vector) else (value,)
        if len(items) != shapes.FORMS[form]:
            wanted = {2: "[radius, height]", 3: "[a, b, c]"}[shapes.FORMS[form]]
            self.error(f"a {form} has the sizes {wanted}", value)
            return ()
        target = self._lengths("a size is a length")
        found = [self._number(item, scope, "a size", target) for item in items]
        return tuple(part for parts in found for part in parts) if all(found) else ()

    def _turn(self, value: Expr | None, scope: Scope) -> tuple[Expr, ...]:
        """Returns the 9 elements of a rotation matrix, column by column."""
        if value is None:
            return ()
        _, facts = self.factor(value, scope)
        if not facts.known:
            return ()
        if not facts.turns:
            message = f"{self.text(value)} is no rotation: a body is drawn as one turns it"
            help = "e.g. draw body rot([0, 0, 1], phi) at P box [a, b, c]; or leave it out"
            self.error(message, value, help)
            return ()
        self.use_inputs(facts)
        at = value.span
        columns = [applied(facts.turns, written(axis, at), at) for axis in UNIT.values()]
        return tuple(component(column, axis) for column in columns for axis in range(len(AXES)))

    def _coordinates(self, statement: st.Draw) -> tuple[str, ...]:
        (_, _, first), second = statement.parts[0], statement.also
        found = []
        for expr in (first, second):
            entry = self.names.table.get(expr.id) if isinstance(expr, Name) else None
            if entry is None or entry.kind != "coordinate" or expr.index is not None:
                message = "a level is drawn over coordinates"
                self.error(message, expr, "e.g. draw level V in x, y")
            else:
                entry.used = True
                found.append(expr.id)
        return tuple(found) if len(found) == 2 else ()

    def _level(self, value: Expr, scope: Scope, axes: tuple[str, ...]) -> tuple[Expr, ...]:
        found, facts = self.checked(value, scope)
        if not facts.known or not axes:
            return ()
        if facts.vector:
            self.error("a level is of a number", value, "take a component, or norm(a)")
            return ()
        for name in axes:
            if name not in facts.coordinates:
                message = f"{self.text(value)} does not depend on {name}"
                help = "its contours would be straight lines: draw what changes with both"
                self.error(message, value, help)
        self.use_inputs(facts)
        return (found,)


_NEEDED = {shapes.AXIS: "an axis and a value", shapes.VALUE: "an expression"}


def _end(span: Span) -> Span:
    return Span(span.end - 1, span.end)


def _components(vector: Expr) -> tuple[Expr, ...]:
    return tuple(component(vector, axis) for axis in range(len(AXES)))
