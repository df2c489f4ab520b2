"""Parses values and names in options of the command line: `30 [cm]`, `q[1]'`.

It uses the lexer, parser and units of models, so that a text has the same meaning as in a model.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from lark.exceptions import UnexpectedToken
from lark.lexer import Token

from ...indices import NotAnInteger, indexed, integer
from ...record import record
from ...source import Diagnostic, ModelError, Source, Span
from ...tree import COMPONENTS
from ..lexer import statements
from ..parse import measure, parser
from ..parse_errors import explain
from ..read import from_text
from ..units import NONE, parse_unit
from .expr import Expressions
from .names import NAMED, Entry, Facts, Names, Report
from .scope import PLACES, Scope
from .shared import as_is
from .values import NoValue, checked, evaluate

_LONGEST = 1_000  # Longest option, in characters.
_COMPONENT = re.compile(rf"(.*)(\.[{COMPONENTS}])('*)\s*")


class OptionError(Exception):
    """The text of an option cannot be parsed. text() shows the error in the way in which errors of
    a model are shown."""

    def __init__(self, source: Source, diagnostic: Diagnostic):
        super().__init__(diagnostic.message)
        self.source, self.diagnostic = source, diagnostic

    def text(self) -> str:
        """Returns the message, the option with a caret at the error, and the hint."""
        _, line, caret, *help = self.diagnostic.text(self.source).split("\n")
        shown = (part.partition("| ")[2] for part in (line, caret))
        return "\n".join([self.diagnostic.message, *(f"   {s}" for s in shown), *help])


@record
class LeftSide:
    """The target of an option: its name, its index (None without one) and the number of primes.
    `q[1]'` is LeftSide("q", 1, 1), `q` is LeftSide("q", None, 0), `r[1].x` is LeftSide("r.x", 1,
    0)."""

    name: str
    index: int | None
    order: int

    def text(self) -> str:
        return indexed(self.name, self.index) + "'" * self.order


def quantity(
    text: str,
    unit: str = "",
    *,
    dimensionless: bool = False,
    values: Mapping[str, int] = {},
    name: str = "the value",
) -> Fraction | float:
    """Returns the value of a text such as `30 [cm]`, in SI. A number without a unit has the unit
    `unit`, which is an SI unit. `values` has the sizes that the text may use; `name` is what
    messages call the value. Raises OptionError."""
    source = _source(text)
    setting = _parsed(source, [Token("UNTIL", "until", start_pos=0, end_pos=0)], [])
    dimension = NONE if dimensionless else parse_unit(unit).dimension if unit else NONE
    report = Report()
    names = Names(report, lambda span: 1)
    names.missing = "a value may use numbers, pi and sizes"
    for size, value in values.items():
        facts = Facts(NONE, False, Fraction(value), bare=True)
        names.table[size] = Entry(size, "size", facts, Span(0, 0))
    expressions = Expressions(source, report, names, dict(values), dimensionless=dimensionless)
    target = as_is(name, dimension)
    expr, _ = expressions.wanted(setting.value, Scope(PLACES["option"]), target)
    if report.errors:
        raise OptionError(source, report.errors[0])
    try:
        return checked(evaluate(expr, {}, dict(values)))
    except NoValue as error:
        raise OptionError(source, Diagnostic(str(error), expr.span)) from None


def left_side(text: str, sizes: Mapping[str, int] = {}) -> LeftSide:
    """Parses the target of `--start`, such as `a`, `q[1]` or `q[1]'`. Raises OptionError."""
    component = _COMPONENT.fullmatch(text)
    if component:
        side = left_side(component[1] + component[3], sizes)
        return replace(side, name=side.name + component[2])
    source = replace(_source(text), dotted=True)
    end = len(source.text)
    tail = [
        Token("EQUAL", "=", start_pos=end, end_pos=end),
        Token("NUMBER", Fraction(0), start_pos=end, end_pos=end),
    ]
    start = _parsed(source, [Token("START", "start", start_pos=0, end_pos=0)], tail)
    item = start.items[0]
    if item.function in NAMED and len(start.items) == 1:
        name = f"{item.function}({item.left.name})"
        item = replace(item, function="", left=replace(item.left, name=name))
    if len(start.items) > 1 or item.function or item.left.range is not None:
        message = "one coordinate or rate is needed here, e.g. theta, theta', q[1]'"
        raise OptionError(source, Diagnostic(message, item.span))
    index = item.left.index
    try:
        at = None if index is None else integer(index, sizes)
    except NotAnInteger as error:
        raise OptionError(source, Diagnostic(error.message, error.span)) from None
    return LeftSide(item.left.name, at, item.order)


def _source(text: str) -> Source:
    if len(text) > _LONGEST:
        source = Source("option", text[:60])
        raise OptionError(source, Diagnostic(f"more than {_LONGEST} characters", Span(0, 1)))
    try:
        source = from_text("option", text)
    except ModelError as error:
        raise OptionError(error.source, error.diagnostics[0]) from None
    if not text.strip():
        raise OptionError(source, Diagnostic("a value is missing", Span(0, 0)))
    if "\n" in source.text or "#" in source.text:
        raise OptionError(source, Diagnostic("one value on one line is needed", Span(0, 1)))
    return source


def _parsed(source: Source, before: list[Token], after: list[Token]) -> object:
    lexed = statements(source, before)[0]
    if lexed.errors:
        raise OptionError(source, lexed.errors[0])
    lexed.tokens += after
    lark, _ = parser()
    try:
        statement = lark.parse(lexed.tokens)
    except UnexpectedToken as error:
        found = explain(source, lexed, error)
        message, help = found.message, found.help
        # The user did not write the `until` that this message is about.
        if message.endswith("takes one item"):
            message, help = "one value is needed here", ""
        elif help.startswith(("the form", "e.g.")):
            help = ""
        raise OptionError(source, Diagnostic(message, found.span, help)) from None
    wrong = measure(statement)[1]
    if wrong is not None:
        raise OptionError(source, wrong)
    return statement
