"""Rules for common syntax mistakes, each with its message and hint.

A rule receives the Spot where the parser failed. It returns None if it does not apply, else the
message, the hint and, if the mistake is elsewhere, its span. RULES are tried in order.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from lark.lexer import Token

from ..functions import FUNCTIONS
from ..record import record
from ..source import Source, Span
from .foreign import STEP
from .lexed import Lexed
from .table import STATEMENTS, SYNTAX
from .units import bare_unit, bracketed
from .words import CLAUSE_WORDS

# Clause -> the clause that must come after it, and an example with both clauses.
ORDER = {
    "every": ("at", "record a, energy every 0.01 [s] at EVENT"),
    "step": ("rtol", "method dop853 step 0.01 [s] rtol 1e-9"),
    "within": ("at", STATEMENTS["expect"].form),
}
# Token type -> its name in messages.
WHAT = {
    "EQUAL": "'='", "COLON": "':'", "DOTS": "'..'", "_COMMA": "','", "RPAREN": "')'",
    "RBRACKET": "']'", "NAME": "a name", "LEND": "'(' or '['", "REND": "')' or ']'",
}  # fmt: skip
_VALUE_STARTS = frozenset(("NAME", "NUMBER", "FUNCTION", "SUM", "LPAREN", "LVECTOR"))
_VALUE_ENDS = frozenset(
    ("NAME", "NUMBER", "PRIME", "COMPONENT", "MEMBER", "RPAREN", "RBRACKET", "UNIT")
)
BINARY = frozenset(("PLUS", "MINUS", "TIMES", "OVER", "POWER"))
_LISTS = frozenset(word for word, row in STATEMENTS.items() if "(_COMMA" in SYNTAX[row.syntax])


@record
class Spot:
    """The position where the parser failed, and the tokens around it."""

    source: Source
    lexed: Lexed
    token: Token  # The rejected token; its type is $END at the statement's end.
    before: Token  # The last accepted token.
    after: Token | None
    expected: frozenset[str]

    @property
    def span(self) -> Span:
        if self.token.type == "$END":
            return Span(self.before.end_pos, self.before.end_pos)
        return Span(self.token.start_pos, self.token.end_pos)

    @property
    def word(self) -> str:
        return self.lexed.keyword

    @property
    def form(self) -> str:
        """The syntax of the statement, for hints; "" if its keyword is unknown."""
        return STATEMENTS[self.word].form if self.word in STATEMENTS else ""

    def text(self, token: Token) -> str:
        return self.source.text[token.start_pos : token.end_pos]

    def wants_value(self) -> bool:
        return "NUMBER" in self.expected


def _decimal_comma(spot: Spot):
    text = spot.source.text
    comma = spot.token if spot.token.type == "_COMMA" else spot.before
    number = re.compile(r"[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?(?![\w.])")
    if comma.type != "_COMMA":
        return None
    left = re.search(r"(?<![\w.])[0-9]+$", text[max(0, comma.start_pos - 50) : comma.start_pos])
    right = number.match(text, comma.end_pos)
    if not left or not right:
        return None
    return (
        f"'{left.group()},{right.group()}': a decimal is written with a point",
        f"write {left.group()}.{right.group()}",
        Span(comma.start_pos - len(left.group()), right.end()),
    )


def _model_name(spot: Spot):
    if spot.word == "model" and spot.token.type not in ("$END", spot.token.upper()):
        help = "it names the C files and begins every C symbol; -o gives the directory"
        return "a model's name is one word of letters, digits and '_'", help


def _sum_form(spot: Spot):
    """Recognizes a wrong or missing range directly within the brackets of a sum."""
    opened, before = [], ""
    for token in spot.lexed.tokens:
        if token is spot.token:
            break
        if token.type in ("LPAREN", "LINDEX", "LVECTOR", "LEND"):
            opened.append(before)
        elif token.type in ("RPAREN", "RBRACKET", "REND") and opened:
            opened.pop()
        before = token.type
    stuck = spot.token.type in ("EQUAL", "NUMBER", "RPAREN") and not spot.wants_value()
    if stuck and opened and opened[-1] == "SUM":
        return "a sum says what runs over which range", "the form is: sum(m/2*q[i]'^2, i = 1..N)"


def _family_left(spot: Spot):
    if spot.token.type == "DOTS" and any(t.type == "LINDEX" for t in spot.lexed.tokens):
        low, high = spot.text(spot.before), spot.text(spot.after) if spot.after else ""
        return "a range needs the name of its variable", f"write [i = {low}..{high}]"


def _nothing_after_keyword(spot: Spot):
    if spot.token.type == "$END" and spot.before is spot.lexed.tokens[0]:
        needs = "an expression" if spot.wants_value() else "a name"
        return f"'{spot.word}' needs {needs} after it", f"e.g. {spot.form}"


def _reserved_word(spot: Spot):
    word = str(spot.token)
    if word not in STATEMENTS.keys() | CLAUSE_WORDS or spot.token.type != word.upper():
        return None
    bounds = word == "in" and spot.after is not None and spot.after.type == "LEND"
    meant = "NAME" in spot.expected and (spot.after is not None or not spot.wants_value())
    if not (meant and not bounds):
        if word not in STATEMENTS:
            return None
        if spot.before.type in _VALUE_ENDS:
            return f"'{word}' starts a statement of its own", "put it on a new line"
    help = "put a column's name in quotes" if spot.word == "table" else "choose another name"
    return f"'{word}' is a word of the language and cannot be a name", help


def _index_without_space(spot: Spot):
    """Recognizes `coord theta[rad]`: a bracket that touches the name is an index."""
    tokens = spot.lexed.tokens
    if spot.word not in ("coord", "input", "state") or "DOTS" not in spot.expected:
        return None
    opening = max((i for i, t in enumerate(tokens) if t.type == "LINDEX"), default=None)
    if opening is None:
        return None
    name = str(tokens[opening - 1])
    inside = spot.source.text[tokens[opening].start_pos :].split("]")[0] + "]"
    span = Span(tokens[opening].start_pos, tokens[opening].start_pos + len(inside))
    if re.fullmatch(r"\[[0-9]+\]", inside):
        return (
            f"a family is declared with its range, not '{name}{inside}'",
            f"write {name}[1..{inside[1:-1]}]",
            span,
        )
    return (
        f"'{name}{inside}': a bracket that touches a name is an index",
        f"put a space before a unit: {name} {inside}",
        span,
    )


def _unit_in_the_middle(spot: Spot):
    if spot.before.type == "UNIT" and spot.token.type in BINARY | _VALUE_STARTS | {"UNIT"}:
        unit = spot.text(spot.before)
        if spot.token.type == "POWER":
            return f"a power of what has the unit {unit}", f"put it in brackets, e.g. (2 {unit})^2"
        return f"an operator is missing after the unit {unit}", f"a product is written 2 {unit}*x"


def _one_name_a_line(spot: Spot):
    if spot.token.type != "_COMMA" or spot.word in _LISTS or "RPAREN" in spot.expected:
        return None
    if spot.word in STATEMENTS and spot.before.type in _VALUE_ENDS:
        return f"'{spot.word}' takes one item", f"start a new line with '{spot.word}' for the next"


def _missing_operator(spot: Spot):
    if spot.token.type == "LPAREN" and spot.before.type == "PRIME":
        return "a prime stands after the brackets of a function", "e.g. sin(x)'"
    if spot.token.type not in _VALUE_STARTS or "TIMES" not in spot.expected:
        return None
    left, right = spot.text(spot.before), spot.text(spot.token)
    unit = bare_unit(spot.source.text, spot.token.start_pos)
    if spot.before.type == "NUMBER" and unit:
        at = spot.token.start_pos
        return f"the unit {unit} has no brackets", bracketed(left, unit), Span(at, at + len(unit))
    if left in FUNCTIONS:
        return f"the argument of '{left}' stands in brackets", f"write {left}({right})"
    if right in ("if", "when", "else", "where"):
        return f"'{right}' has no place in an expression", STEP
    power = re.search(r"(\w+)\s*(\^|\*\*)\s*$", spot.source.text[: spot.before.start_pos])
    if right == "(" and power and power[1] in FUNCTIONS:
        message = f"the argument of '{power[1]}' stands right behind it"
        return message, f"write {power[1]}(…)^{left}"
    left = "…" if "[" in left else left
    product = f"{'(…)' if left == ')' else left}*{right}" + ("…)" if right == "(" else "")
    message = f"an operator is missing between '{left}' and '{right}'"
    return message, f"a product is written {product}"


def _no_name_wanted(spot: Spot):
    """Recognizes a name where none is allowed: `kinetic T = …`."""
    if spot.token.type != "EQUAL" or "EQUAL" in spot.expected:
        return None
    if spot.word in ("kinetic", "potential", "lagrangian", "dissipation"):
        help = f"e.g. {spot.form}; a name is defined with 'let'"
        return f"'{spot.word}' takes an expression, not a definition", help
    if spot.word == "coord":
        return "a coordinate has no value", f"its start is a statement: start {spot.before} = …"
    return "this '=' has no place here", f"the form is: {spot.form}"


def _prime_misplaced(spot: Spot):
    if spot.token.type != "PRIME":
        return None
    if spot.before.type == "NUMBER":
        return f"{spot.text(spot.before)} is a number and has no rate", ""
    if "EQUAL" in spot.expected:
        return "this side of the definition has no prime", f"the form is: {spot.form}"
    help = "the rate of x is x'; of a whole expression (a*b)'"
    return "a prime stands after a name, an index, a call or a bracket", help


def _comparison(spot: Spot):
    if spot.token.type not in ("LESS", "GREATER", "AT_MOST", "AT_LEAST", "SAME"):
        return None
    if what := {"expect": "an expectation", "contact": "a contact"}.get(spot.word):
        return f"'{spot.token}' has no place in {what}", f"the form is: {spot.form}"
    if spot.token.type == "SAME" and "EQUAL" in spot.expected:
        return "'==' compares", "one '=' defines a name"
    return f"'{spot.token}' compares: a condition cannot stand here", STEP


def _clause_order(spot: Spot):
    """Recognizes clauses in the wrong order, `record x at up every 0.5`."""
    clause = str(spot.token)
    if clause not in ORDER:
        return None
    then, form = ORDER[clause]
    before = {str(t) for t in spot.lexed.tokens if t.start_pos < spot.token.start_pos}
    if then in before and clause not in before:
        return f"'{clause}' comes before '{then}'", f"the form is: {form}"


def _value_missing(spot: Spot):
    if not spot.wants_value():
        return None
    if spot.before.type in BINARY or spot.token.type == "$END":
        side = f"after '{spot.text(spot.before)}'"
    else:
        side = f"before '{spot.text(spot.token)}'"
    before = spot.source.text[: spot.token.start_pos].rstrip()
    comment = spot.text(spot.token) == "/" == before[-1:]
    return f"a value is missing {side}", "a comment begins with #" if comment else ""


def _something_missing(spot: Spot):
    """The last rule. If only one or two kinds of token can follow, it names them as missing;
    otherwise it names the rejected token."""
    wanted = [WHAT[t] for t in WHAT if t in spot.expected]
    if "EQUAL" in spot.expected and spot.word != "expect":
        wanted = ["'='"]
    shown = "the end of the statement"
    if spot.token.type != "$END":
        shown = f"'{spot.text(spot.token)}'"
    help = f"the form is: {spot.form}" if spot.word in STATEMENTS else ""
    if wanted and len(wanted) <= 2:
        return f"{' or '.join(wanted)} is missing before {shown}", help
    if spot.token.type == "$END":
        return "the statement is not complete", help
    return f"{shown} has no place here", help


def _string_misplaced(spot: Spot):
    if spot.token.type == "STRING":
        return f"{spot.text(spot.token)[:40]}: no string stands here", "names have no quotes"


RULES: tuple[Callable[[Spot], tuple[str, str] | None], ...] = (
    _string_misplaced,
    _decimal_comma,
    _model_name,
    _sum_form,
    _index_without_space,
    _family_left,
    _unit_in_the_middle,
    _nothing_after_keyword,
    _reserved_word,
    _prime_misplaced,
    _missing_operator,
    _no_name_wanted,
    _comparison,
    _one_name_a_line,
    _clause_order,
    _value_missing,
    _something_missing,
)
