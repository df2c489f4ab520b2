"""The callbacks of grammar.lark: tokens and finished parts to expressions and statements.

They run while the LALR parser reduces, so nothing here recurses, however long a sum is.
"""

from __future__ import annotations

from dataclasses import replace

from lark import Transformer
from lark.lexer import Token

from ..source import Span
from ..tree import (
    Add,
    Call,
    Component,
    Expr,
    Multiply,
    Name,
    Negate,
    Number,
    Power,
    Prime,
    Quantity,
    Range,
    Sum,
    Vector,
)
from . import statements as st

_SIGNS = {"PLUS": 1, "MINUS": -1, "TIMES": 1, "OVER": -1}


def _span(part: object) -> Span:
    return Span(part.start_pos, part.end_pos) if isinstance(part, Token) else part.span


def _over(first: object, last: object) -> Span:
    return Span(
        first.start_pos if isinstance(first, Token) else first.span.start,
        last.end_pos if isinstance(last, Token) else last.span.end,
    )


class Build(Transformer):
    """One method a rule of the grammar. `describe` sets the comment of the statement at hand."""

    def __init__(self) -> None:
        super().__init__()
        self.comment = ""

    def start(self, parts):
        return parts[0]

    # expressions

    def number(self, parts):
        return Number(parts[0].value, _span(parts[0]))

    def name(self, parts):
        return Name(str(parts[0]), None, _span(parts[0]))

    def member(self, parts):
        name, _, index, close = parts
        return Name(str(name), index, _over(name, close))

    def prime(self, parts):
        return Prime(parts[0], _over(parts[0], parts[1]))

    def component(self, parts):
        return Component(parts[0], parts[1].value, _over(parts[0], parts[1]))

    def negate(self, parts):
        return Negate(parts[1], _over(parts[0], parts[1]))

    def positive(self, parts):
        return parts[1]

    def raised(self, parts):
        return Power(parts[0], parts[2], _over(parts[0], parts[2]))

    def _chain(self, node, parts):
        signs = (1, *(_SIGNS[sign.type] for sign in parts[1::2]))
        return node(tuple(parts[::2]), signs, _over(parts[0], parts[-1]))

    def add(self, parts):
        return self._chain(Add, parts)

    def multiply(self, parts):
        return self._chain(Multiply, parts)

    def quantity(self, parts):
        of, unit = parts
        return Quantity(of, str(unit), _span(unit), _over(of, unit))

    def group(self, parts):
        return replace(parts[1], span=_over(parts[0], parts[2]))

    def vector(self, parts):
        return Vector(tuple(parts[1:-1]), _over(parts[0], parts[-1]))

    def call(self, parts):
        function, _, *arguments, close = parts
        given = tuple(a for a in arguments if a is not None)
        return Call(str(function), given, _over(function, close))

    def sum_over(self, parts):
        word, _, body, *ranges, close = parts
        return Sum(body, tuple(ranges), _over(word, close))

    def range(self, parts):
        name, _, lo, _, hi = parts
        return Range(str(name), lo, hi, _over(name, hi))

    # parts of statements

    def left_name(self, parts):
        return st.Left(str(parts[0]), None, None, _span(parts[0]))

    def left_member(self, parts):
        return st.Left(str(parts[0]), parts[2], None, _over(parts[0], parts[3]))

    def left_family(self, parts):
        return st.Left(str(parts[0]), None, parts[2], _over(parts[0], parts[3]))

    def declared(self, parts):
        name, bracket, lo, _, hi, close, unit = parts
        text = None if unit is None else st.UnitText(str(unit), _span(unit))
        span = _span(name) if bracket is None else _over(name, close)
        return st.Declared(str(name), lo, hi, text, span, _span(name))

    def interval(self, parts):
        _, opens, lo, hi, closes = parts
        return st.Interval(lo, hi, opens == "(", closes == ")", _over(opens, closes))

    def pair(self, parts):
        return parts[0], parts[2]

    def alone(self, parts):
        return parts[0], None

    def start_item(self, parts):
        left, value = parts[0], parts[-1]
        last = parts[-3] if len(parts) > 3 else left
        return st.StartItem(left, len(parts) - 3, "", value, _over(left, last))

    def start_function(self, parts):
        function, _, name, close, _, value = parts
        left = st.Left(str(name), None, None, _span(name))
        return st.StartItem(left, 0, str(function), value, _over(function, close))

    def word(self, parts):
        return parts[0]

    def clause(self, parts):
        return parts[1]

    # statements; the first part is the keyword

    def model(self, parts):
        return st.ModelName(str(parts[1]), _span(parts[1]), self.comment, _over(*parts))

    def param(self, parts):
        word, left, _, value, interval = parts
        end = value if interval is None else interval
        return st.Param(left, value, interval, self.comment, _over(word, end))

    def size(self, parts):
        return st.SizeOf(parts[1], parts[3], self.comment, _over(parts[0], parts[3]))

    def define(self, parts):
        word, left, _, value = parts
        return st.Define(str(word), left, value, self.comment, _over(word, value))

    def declare(self, parts):
        word, *items = parts
        return st.Declare(str(word), tuple(items), self.comment, _over(word, items[-1]))

    def ends(self, parts):
        word, *items = parts
        left, value = items[-1]
        return st.Ends(str(word), tuple(items), _over(word, value or left))

    def energy(self, parts):
        return st.Energy(str(parts[0]), parts[1], _over(*parts))

    def force(self, parts):
        return st.ForceAlong(parts[1], parts[3], _over(parts[0], parts[3]))

    def equation(self, parts):
        word, left, _, a, _, b = parts
        return st.Equation(str(word), left, a, b, _over(word, b))

    def event(self, parts):
        word, name, _, value, direction, stop = parts
        last = next(p for p in (stop, direction, value) if p is not None)
        return st.Event(
            str(name),
            _span(name),
            value,
            "either" if direction is None else str(direction),
            stop is not None,
            self.comment,
            _over(word, last),
        )

    def of(self, parts):
        return "", parts[0]

    def level_at(self, parts):
        return str(parts[0]), parts[2]

    def part(self, parts):
        return str(parts[0]), _span(parts[0]), parts[1]

    def draw(self, parts):
        word, shape, subject, *given, also = parts
        axis, value = subject or ("", None)
        last = also or (given[-1][2] if given else value) or shape
        shown = (str(word), str(shape), value, axis, tuple(given), also, self.comment)
        return st.Draw(*shown, _span(shape), _over(word, last))

    def start_at(self, parts):
        return st.StartAt(tuple(parts[1:]), _over(parts[0], parts[-1].value))

    def scene(self, parts):
        return st.SceneHead(str(parts[1]), _span(parts[1]), self.comment, _over(*parts))

    def end_of_scene(self, parts):
        return st.EndOfScene(_span(parts[0]))

    def assign(self, parts):
        word, *items = parts
        left, value = items[-1]
        return st.Assign(str(word), tuple(items), _over(word, value or left))

    def setting(self, parts):
        return st.Setting(str(parts[0]), parts[1], _over(*parts))

    def method(self, parts):
        word, name, _, step, _, rtol = parts
        last = next(p for p in (rtol, step, name) if p is not None)
        return st.Method(str(name), _span(name), step, rtol, _over(word, last))

    def record(self, parts):
        word, *items, every, at = parts
        last: Expr = at or every or items[-1]
        return st.Record(tuple(items), every, at, _over(word, last))

    def swarm(self, parts):
        return st.Swarm(parts[1], _over(*parts))

    def expect(self, parts):
        word, a, relation, b, within, at = parts
        return st.Expect(a, str(relation), b, within, at, _over(word, at or within or b))
