"""Messages for statements that do not parse, with a hint where one is known.

The parser reports the token that it rejected and the token types it accepts. The rules in
`parse_mistakes.py` are tried in order; each recognizes one common mistake.
"""

from __future__ import annotations

from difflib import get_close_matches

from lark.exceptions import UnexpectedToken
from lark.lexer import Token
from lark.parsers.lalr_analysis import Shift

from ..source import Diagnostic, Source, Span
from . import foreign
from .lexed import Lexed
from .parse_mistakes import BINARY, RULES, Spot
from .table import ALL, BOTH, FIRST, MODEL, SAMPLE, STATEMENTS

_ENERGIES = {"L": "lagrangian", "T": "kinetic"} | dict.fromkeys("UV", "potential")


def explain(source: Source, lexed: Lexed, error: UnexpectedToken) -> Diagnostic:
    """Returns the parser's error as a message in the words of the language."""
    tokens = lexed.tokens
    at = next((i for i, t in enumerate(tokens) if t is error.token), len(tokens))
    token = tokens[at] if at < len(tokens) else Token("$END", "")
    if at == 0:
        return _not_a_statement(source, lexed)
    after = tokens[at + 1] if at + 1 < len(tokens) else None
    spot = Spot(source, lexed, token, tokens[at - 1], after, _acceptable(error.state))
    message, help, *span = next(filter(None, (rule(spot) for rule in RULES)))  # the last answers
    return Diagnostic(message, span[0] if span else spot.span, help)


def _acceptable(parser) -> frozenset[str]:
    """Returns the token types that the parser accepts in its present state. lark's own answers are
    not used: `expected` includes types that fail after a reduction, and `accepts` copies whole
    trees."""
    states = parser.parse_conf.states
    return frozenset(
        kind
        for kind in states[parser.state_stack[-1]]
        if kind.isupper() and _leads_to_shift(states, list(parser.state_stack), kind)
    )


def _leads_to_shift(states, stack: list, kind: str) -> bool:
    while kind in states[stack[-1]]:
        action, argument = states[stack[-1]][kind]
        if action is Shift or kind == "$END":
            return True
        if argument.expansion:
            del stack[-len(argument.expansion) :]
        stack.append(states[stack[-1]][argument.origin.name][1])
    return False


def misplaced(lexed: Lexed) -> Diagnostic:
    """Returns the error about a block's clause that is not in such a block."""
    word = lexed.keyword
    if word == "end":
        return Diagnostic("this 'end' ends no scene", lexed.span)
    where = STATEMENTS[word].stands_in
    message = f"'{word}' stands in {where} only"
    help = f"put it between '{'sample' if where == SAMPLE else 'scene'} NAME' and 'end'"
    return Diagnostic(message, Span(lexed.tokens[0].start_pos, lexed.tokens[0].end_pos), help)


def declared_names(lexed: Lexed) -> tuple[str, ...]:
    """Returns the names that a broken statement would probably declare."""
    word = lexed.keyword
    names = [str(t) for t in lexed.tokens if t.type == "NAME"]
    declares = STATEMENTS[word].declares if word in STATEMENTS else FIRST
    return tuple(names if declares == ALL else names[:1] if declares == FIRST else ())


def _not_a_statement(source: Source, lexed: Lexed) -> Diagnostic:
    first = lexed.tokens[0]
    span = Span(first.start_pos, first.end_pos)
    shown = source.text[first.start_pos : first.end_pos]
    types = [t.type for t in lexed.tokens]
    near = get_close_matches(shown.lower(), sorted(STATEMENTS), 1, 0.7)
    line = source.text[first.start_pos : lexed.span.end]
    if first.type in BINARY:
        help = "an expression goes on in the next line only while a bracket is open: put it in ( )"
        help = foreign.statement(line) or help
    elif shown in _ENERGIES and types[1:2] == ["EQUAL"]:
        help = f"write '{_ENERGIES[shown]} …', which needs no name and no '='"
    elif shown in STATEMENTS:
        help = f"the form is: {STATEMENTS[shown].form}"
    elif help := foreign.statement(line):
        pass
    elif near and (len(types) < 2 or types[1] not in ("EQUAL", "LINDEX", "PRIME")):
        help = f"did you mean '{near[0]}'?"
    elif first.type in ("NAME", "LINDEX") and "EQUAL" in types:
        help = f"write 'let {shown} = …' for a definition, 'param {shown} = …' for a parameter"
    else:
        words = (word for word, row in STATEMENTS.items() if row.stands_in in (MODEL, BOTH))
        help = f"a statement is one of: {' '.join(words)}"
    return Diagnostic(f"a statement cannot start with '{shown}'", span, help)
