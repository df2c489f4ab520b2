"""The callbacks of grammar.lark: they build expressions and statements from tokens and parts.

They run while the LALR parser reduces, so there is no recursion, however long a sum is.
"""

from __future__ import annotations

from dataclasses import replace

from lark import Transformer, v_args
from lark.lexer import Token

from .. import tree
from ..source import Span
from ..tree import Range
from . import statements as st

_SIGNS = {"PLUS": 1, "MINUS": -1, "TIMES": 1, "OVER": -1}


def _over(first: object, last: object) -> Span:
    return Span(
        first.start_pos if isinstance(first, Token) else first.span.start,
        last.end_pos if isinstance(last, Token) else last.span.end,
    )


def _span(part: object) -> Span:
    return _over(part, part)


def _chain(node: type, parts: tuple) -> tree.Expr:
    signs = (1, *(_SIGNS[sign.type] for sign in parts[1::2]))
    return node(parts[::2], signs, _over(parts[0], parts[-1]))


def _product(parts: tuple) -> tree.Expr:
    return _chain(tree.Multiply, parts) if len(parts) > 1 else parts[0]


@v_args(inline=True)
class Build(Transformer):
    """One method for each rule of the grammar. `comment` is the comment of the current
    statement."""

    comment = ""

    # expressions

    def number(self, number):
        return tree.Number(number.value, _span(number))

    def name(self, name, _=None, index=None, close=None):
        return tree.Name(str(name), index, _over(name, close or name))

    def prime(self, of, sign):
        return tree.Prime(of, _over(of, sign))

    def component(self, of, axis):
        return tree.Component(of, axis.value, _over(of, axis))

    def member(self, name, *parts):
        """Builds a member of a body, `upper.com` or `link[i].com`, as a Name."""
        *index, which = parts
        at = index[1] if index else None
        return tree.Name(f"{name}{which}", at, _over(name, which))

    def point(self, name, *parts):
        """Builds `upper.point(r)` as upper.origin + upper.R*r."""
        *index, point, _, place, close = parts
        at, to = _over(name, close), index[1] if index else None
        origin, turn = (tree.Name(f"{name}.{m}", to, _over(name, point)) for m in ("origin", "R"))
        return tree.Add((origin, tree.Multiply((turn, place), (1, 1), at)), (1, 1), at)

    def negate(self, sign, of):
        return tree.Negate(of, _over(sign, of))

    def second(self, _, part):
        return part

    def raised(self, base, _, exponent):
        return tree.Power(base, exponent, _over(base, exponent))

    def add(self, *parts):
        return _chain(tree.Add, parts)

    def multiply(self, *parts):
        """Builds a product. A unit in it applies to all factors before the unit, until
        check/quantities.py decides otherwise."""
        made: tuple = ()
        for part in parts:
            if getattr(part, "type", "") == "UNIT":
                of = _product(made)
                made = (tree.Quantity(of, str(part), _span(part), _over(of, part), whole=False),)
            else:
                made = (*made, part)
        return _product(made)

    def item(self, of):
        """Returns the expression `of`. A unit at its end applies to the whole expression, until
        check/quantities.py decides otherwise."""
        last = of.terms[-1] if isinstance(of, tree.Add) else of
        if not isinstance(last, tree.Quantity) or last.whole:
            return of
        if of is not last:
            span = tree.Span(of.span.start, last.of.span.end)
            terms = (*of.terms[:-1], last.of)
            of = tree.Add(terms, of.signs, span)
            return replace(last, of=of, span=tree.Span(span.start, last.span.end), whole=True)
        return replace(last, whole=True)

    def group(self, opens, of, closes):
        return replace(of, span=_over(opens, closes))

    def compared(self, a, sign, b):
        return tree.Condition(str(sign), (a, b), _over(a, b))

    def logical(self, *parts):
        return tree.Condition(str(parts[1]), parts[::2], _over(parts[0], parts[-1]))

    def denied(self, sign, of):
        return tree.Condition(str(sign), (of,), _over(sign, of))

    def vector(self, opens, *items):
        return tree.Vector(items[:-1], _over(opens, items[-1]))

    def call(self, function, _, *arguments):
        *given, close = arguments
        given = tuple(a for a in given if a is not None)
        return tree.Call(str(function), given, _over(function, close))

    def sum_over(self, word, _, body, *ranges):
        return tree.Sum(body, ranges[:-1], _over(word, ranges[-1]))

    def range(self, name, _, lo, __, hi):
        return Range(str(name), lo, hi, _over(name, hi))

    # parts of statements

    def left(self, name, _=None, index=None, close=None):
        one, many = (None, index) if isinstance(index, Range) else (index, None)
        return st.Left(str(name), one, many, _over(name, close or name))

    def left_range(self, name, _, lo, __, hi, close):
        """Builds `link[1..N]`, a family without a loop variable."""
        span = _over(name, close)
        return st.Left(str(name), None, Range("", lo, hi, span), span)

    def left_member(self, name, _, index, __, member):
        return st.Left(f"{name}{member}", index, None, _over(name, member))

    def declared(self, name, bracket, lo, _, hi, close, unit):
        text = None if unit is None else st.UnitText(str(unit), _span(unit))
        return st.Declared(str(name), lo, hi, text, _over(name, close or name), _span(name))

    def interval(self, _, opens, lo, hi, closes):
        return st.Interval(lo, hi, opens == "(", closes == ")", _over(opens, closes))

    def pair(self, left, _, value):
        return left, value

    def start_item(self, left, *rest):
        *primes, _, value = rest
        return st.StartItem(left, len(primes), "", value, _over(left, [left, *primes][-1]))

    def start_function(self, function, _, left, close, __, value):
        return st.StartItem(left, 0, str(function), value, _over(function, close))

    # Callbacks of statements: their first argument is the keyword.

    def head(self, word, name):
        of = st.Scene if word == "scene" else st.Head
        return of(str(name), _span(name), self.comment, _over(word, name))

    def param(self, word, left, _, value, interval):
        return st.Param(left, value, interval, self.comment, _over(word, interval or value))

    def define(self, word, left, _, value):
        return st.Define(str(word), left, value, self.comment, _over(word, value))

    def force(self, word, target, *rest):
        *at, _, value = rest
        left, place = (target, *at) if at else (None, target)
        return st.Force(str(word), left, place, value, _over(word, value))

    def observe(self, word, left, *rest):
        _, value, condition = rest if len(rest) > 1 else (None, None, *rest)
        whole = isinstance(value, tree.Call) and value.function == "integral"
        if condition is None and not whole:
            return self.define(word, left, None, value)
        span = _over(word, condition or value)
        return st.Accumulate(str(word), left, value, self.comment, span, condition)

    def declare(self, word, *items):
        return st.Declare(str(word), items, self.comment, _over(word, items[-1]))

    def pairs(self, word, *items):
        items = tuple(x if isinstance(x, tuple) else (x, None) for x in items)
        left, value = items[-1]
        return st.Pairs(str(word), items, _over(word, value or left))

    names = holds = pairs

    def exact(self, word, *rest):
        *items, within = rest
        return st.Pairs(str(word), tuple(items), _over(word, within or items[-1][1]), within)

    def single(self, word, value):
        return st.Single(str(word), value, _over(word, value))

    def equation(self, word, left, _, a, __, b):
        return st.Equation(str(word), left, a, b, _over(word, b))

    def then(self, _, *items):
        return items

    def event(self, word, name, _, value, direction, stop, then):
        toward = "either" if direction is None else str(direction)
        given = str(name), _span(name), value, toward, stop is not None, self.comment
        last = then[-1].value if then else stop or direction or value
        return st.Event(*given, _over(word, last), then=then or ())

    def rubbing(self, _, mu, __, along):
        return mu, along

    def impact(self, word, left, _, gap, direction, __, restitution, rubbing, poisson):
        mu, along = rubbing or (None, None)
        if direction == "rising":
            gap = tree.Negate(gap, gap.span)
        last = poisson or along or mu or restitution or direction
        given = restitution, mu, along, poisson is not None, self.comment
        return st.Contact(str(word), left, gap, None, *given, _over(word, last))

    def contact(self, word, left, _, a, __, b, restitution, rubbing, poisson):
        mu, along = rubbing or (None, None)
        last = poisson or along or mu or restitution or b
        given = restitution, mu, along, poisson is not None, self.comment
        return st.Contact(str(word), left, a, b, *given, _over(word, last))

    def friction(self, word, left, _, value, static):
        return st.Friction(left, value, static, self.comment, _over(word, static or value))

    def mode(self, word, name, _, __, *rest):
        lefts = tuple(x for x in rest if isinstance(x, st.Left))
        on, off = rest[-4], rest[-1]
        last = off or on or lefts[-1]
        at = tuple(None if x is None else tree.Name(str(x), None, _span(x)) for x in (on, off))
        return st.Mode(str(name), _span(name), lefts, *at, self.comment, _over(word, last))

    def of(self, subject):
        return "", subject

    def level_at(self, axis, _, value):
        return str(axis), value

    def part(self, word, value):
        return str(word), _span(word), value

    def draw(self, word, shape, subject, *parts):
        *given, also = parts
        axis, value = subject or ("", None)
        last = also or (given[-1][2] if given else value) or shape
        shown = (str(word), str(shape), value, axis, tuple(given), also, self.comment)
        return st.Draw(*shown, _span(shape), _over(word, last))

    def clause(self, word, *items):
        return str(word), _span(word), items

    def body(self, word, left, *clauses):
        last = clauses[-1][2][-1] if clauses else left
        return st.Body(left, clauses, self.comment, _over(word, last))

    def joint(self, word, left, _, parent, to, child, kind, axis, *clauses):
        last = clauses[-1][2][-1] if clauses else axis or kind
        to, kind = ((str(w), _span(w)) for w in (to, kind))
        said = axis, clauses, self.comment, _over(word, last)
        return st.Joint(left, (parent, child), to, kind, *said)

    def column(self, name, unit):
        return replace(self.declared(name, *[None] * 5, unit), span=_over(name, unit or name))

    def table_word(self, word):
        return str(word), _span(word)

    def table(self, word, name, _, file, *parts):
        words = tuple(x for x in parts if isinstance(x, tuple))
        grid = any(isinstance(x, Token) for x in parts)
        columns = tuple(x for x in parts if isinstance(x, st.Declared))
        span = Span(word.start_pos, words[-1][1].end if words else columns[-1].span.end)
        given = str(name), _span(name), str(file), _span(file), columns, grid, words
        return st.Table(*given, self.comment, span)

    def start_at(self, word, *items):
        if isinstance(items[0], Token):
            return st.StartAt((), _over(word, items[0]), str(items[0]))
        return st.StartAt(items, _over(word, items[-1].value))

    def use(self, word, file, _, name, *rest):
        given = tuple(x for x in rest if isinstance(x, tuple))
        over = _over(word, given[-1][1] if given else name)
        return st.Use(str(file), str(name), _span(name), given, over)

    def end_of_scene(self, word):
        return st.EndOfScene(_span(word))

    def method(self, word, name, _, file, __, step, ___, rtol):
        path = None if file is None else str(file)
        last = rtol or step or file or name
        given = step, rtol, path, None if file is None else _span(file)
        return st.Method(str(name), _span(name), *given, _over(word, last))

    def record(self, word, *parts):
        *items, every, at = parts
        return st.Record(tuple(items), every, at, _over(word, at or every or items[-1]))

    def sample(self, word, name, every, offset, delay):
        given, span = (every, offset, delay, self.comment), _over(word, delay or offset or every)
        return st.Sample(str(name), _span(name), *given, span, span)

    def swarm(self, word, range_):
        return st.Swarm(range_, _over(word, range_))

    def expect(self, word, a, relation, b, within, at):
        return st.Expect(a, str(relation), b, within, at, _over(word, at or within or b))
