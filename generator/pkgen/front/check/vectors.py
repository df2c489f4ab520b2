"""Splits vectors into components, and applies rotations to vectors.

A vector output r becomes three outputs `r.x`, `r.y` and `r.z`; the name r then means the vector of
these. A rotation is a product of factors (class Turn), each a rot(AXIS, ANGLE) or a declared
attitude; the rightmost factor is applied first. Checked expressions contain no rotations, only
rotate(AXIS, ANGLE, VECTOR) and attitude(QUATERNION, VECTOR)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ...model import Definition
from ...source import Span
from ...tree import AXES, COMPONENTS, Add, Call, Component, Expr, Multiply, Name, Sum, Vector
from .names import Facts, Turns, Wrong

EXAMPLE = "rot([0, 0, 1], angle)*r"
UNIT = {"x": "[1, 0, 0]", "y": "[0, 1, 0]", "z": "[0, 0, 1]"}


def component(vector: Expr, axis: int) -> Expr:
    """Returns a component of a checked vector: for a literal [x, y, z] one of its items, for a Sum
    of vectors the Sum of their components, so that it can stay a loop."""
    if isinstance(vector, Vector) and axis < len(vector.items):  # else an error is reported
        return vector.items[axis]
    if isinstance(vector, Sum):
        return replace(vector, body=component(vector.body, axis))
    return Component(vector, axis, vector.span)


def component_name(name: str, axis: int) -> str:
    return f"{name}.{COMPONENTS[axis]}"


def by_component(definition: Definition) -> Iterator[Definition]:
    """Yields a vector output as three scalar outputs."""
    for axis in range(len(AXES)):
        name, value = component_name(definition.name, axis), component(definition.value, axis)
        yield replace(definition, name=name, value=value)


def output_vector(expr: Name) -> Vector:
    """Returns the vector [r.x, r.y, r.z] for the name r of a vector output."""
    names = (replace(expr, id=component_name(expr.id, axis)) for axis in range(len(AXES)))
    return Vector(tuple(names), expr.span)


def turned(expr: Multiply, factors: list[Expr], facts: list[Facts]) -> Expr | None:
    """Returns the product `expr` with its rotations applied to its vector. Returns None if all
    factors are rotations; the factors of their product are then `turns_of(facts)`. Raises Wrong for
    any other product."""
    last = max(i for i, f in enumerate(facts) if f.turns)
    vectors = [i for i, f in enumerate(facts) if f.vector and not f.turns]
    numbers = [i for i, f in enumerate(facts) if not f.vector and not f.turns]
    under = next((i for i, f in enumerate(facts) if f.turns and expr.exponents[i] < 0), None)
    if under is not None:
        at = expr.factors[under].span
        raise Wrong("division by a rotation", "its inverse is inverse(R)", at)
    if vectors and vectors[0] < last:
        at = expr.factors[vectors[0]].span
        raise Wrong("a rotation stands before the vector that it turns", f"e.g. {EXAMPLE}", at)
    if numbers and not vectors:
        at, help = expr.factors[numbers[0]].span, f"it turns a vector: {EXAMPLE}"
        raise Wrong("a rotation is not multiplied by a number", help, at)
    if not vectors:
        return None
    vector = applied(turns_of(facts), factors[vectors[0]], expr.span)
    left = sorted(numbers + vectors)
    rest = tuple(vector if i in vectors else factors[i] for i in left)
    exponents = tuple(expr.exponents[i] for i in left)
    return vector if len(rest) == 1 else Multiply(rest, exponents, expr.span)


def applied(turns: Turns, vector: Expr, span: Span) -> Expr:
    """Returns the vector rotated by the factors; the rightmost is applied first."""
    for turn in reversed(turns):
        if turn.quaternion is not None:
            vector = Call("attitude", (turn.quaternion, vector), span)
        elif turn.rows:
            vector = Vector(tuple(Call("dot", (row, vector), span) for row in turn.rows), span)
        elif turn.columns:
            parts = (
                Multiply((column, component(vector, axis)), (1, 1), span)
                for axis, column in enumerate(turn.columns)
            )
            vector = Add(tuple(parts), (1, 1, 1), span)
        else:
            vector = Call("rotate", (turn.axis, turn.angle, vector), span)
    return vector


def turns_of(facts: list[Facts]) -> Turns:
    return tuple(turn for part in facts for turn in part.turns)
