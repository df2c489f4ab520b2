"""The names that statements declare."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..indices import multipliers
from ..source import Span
from . import statements as st
from .joints import SHOWN, joint_names


def declarations(statements: Iterable[st.Statement]) -> Iterator[tuple[str, Span, str]]:
    """Yields every name that the statements declare, with its source position, and the keyword of
    its declaration if that is `coord`, `state` or `rotation`, for a joint's coordinates too."""
    for statement in statements:
        match statement:
            case st.Define(keyword="rate"):
                pass  # `rate` declares no name.
            case st.Accumulate(left=left):
                yield left.name, left.span, "state"
            case st.Force(left=left, place=place) if place is not None and left is not None:
                yield left.name, left.span, ""
            case st.Param(left=left) | st.Define(left=left) | st.Body(left=left):
                yield left.name, left.span, ""
            case st.Declare(keyword=keyword, items=items):
                yield from ((item.name, item.name_span, keyword) for item in items)
            case st.Joint(left=left, ends=(_, child)):
                yield left.name, left.span, ""
                for coordinate, what in joint_names(statement):
                    yield coordinate, left.span, "rotation" if what == "rotation" else "coord"
                yield from ((f"{child.id}.{member}", left.span, "") for member in SHOWN)
            case st.Friction(left=left):
                yield multipliers(left.name)[0], left.span, ""
            case st.Sample(name=name, name_span=span, clauses=clauses):
                yield name, span, ""
                cells = (c.left for c in clauses if c.keyword == "memory")
                yield from ((left.name, left.span, "") for left in cells)
            case st.Drive(input=item):
                yield item.name, item.name_span, ""
            case (
                st.Use(name=name, name_span=span)
                | st.Event(name=name, name_span=span)
                | st.Table(name=name, name_span=span)
                | st.Mode(name=name, name_span=span)
            ):
                yield name, span, ""
            case st.Equation(left=left) | st.Contact(left=left):
                names = left.name, *multipliers(left.name)
                yield from ((name, left.span, "") for name in names)
