"""Splits a text into statements of typed tokens.

A statement is a line, and continues while a bracket is open; a line that starts with a statement
word ends an unclosed bracket with an error. The meaning of a `[` depends on the token before it
(see `_open_square`); the lexer gives each meaning a token type, which keeps the grammar LALR(1).
All errors in characters, numbers and brackets are found here, in one run.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from fractions import Fraction

from lark.lexer import Token

from .. import limits
from ..source import Diagnostic, Source, Span
from ..tree import COMPONENTS
from .joints import CLAUSES, MEMBERS, WORDS_TO_KIND
from .lexed import Lexed, description
from .shapes import shapes_of, unknown_shape
from .stray_characters import stray_character
from .table import STATEMENTS, Statement
from .units import bare_unit, bracketed
from .words import BEHIND, CLAUSE_WORDS, TABLEAU, greek

_PATTERN = re.compile(
    r"""
    (?P<space>[ \t]+) | (?P<newline>\n) | (?P<comment>\#[^\n]*)
  | (?P<name>[^\W\d]\w*)
  | (?P<number>[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?)
  | (?P<component>\.[A-Za-z_]\w*)
  | (?P<string>"[^"\n]*")
  | (?P<operator>\*\*|\.\.|[<>=]=|->|[-+*/^()\[\],:='<>])
  | (?P<other>.)
    """,
    re.VERBOSE | re.DOTALL,
)
_MORE = re.compile(r"\.([^\W\d]\w*)")
_PATH = re.compile(r"[ \t]*([^\s#]+)")
_NAMED = re.compile(r"""[ \t]+([^\W\d]\w*|")""")
_BRACKET = re.compile(r"[ \t]*\(")
_UNIT = re.compile(r"\[([^\[\]\n#]*)\]")
_OPERATORS = {
    "+": "PLUS", "-": "MINUS", "*": "TIMES", "/": "OVER", "^": "POWER", "**": "POWER",
    ",": "_COMMA", ":": "COLON", "=": "EQUAL", "'": "PRIME", "<": "LESS", ">": "GREATER",
    "<=": "AT_MOST", ">=": "AT_LEAST", "==": "SAME", "..": "DOTS",
    "->": "ARROW",
}  # fmt: skip
_VALUE_ENDS = frozenset(
    ["NAME", "NUMBER", "PRIME", "COMPONENT", "MEMBER", "RPAREN", "RBRACKET", "UNIT", "STRING"]
)
_WORD_ENDS = frozenset(["RISING", "FALLING", "EITHER", "STOP", "WITH"])
_DRAWN = frozenset(word.upper() for word, row in STATEMENTS.items() if row.syntax == "draw")
_OF_BODIES = ("BODY", "JOINT")
_USE = {2: "as", 4: "with"}  # The words of `use`, by the number of tokens before them.
_CLOSERS = {"(": ")", "[": "]"}
_AXES = {f".{name}": axis for axis, name in enumerate(COMPONENTS)}
_TOKENS = 4 * limits.NODES  # Most tokens of a model; enough for limits.NODES nodes of expressions.


def statements(source: Source, before: Iterable[Token] = ()) -> list[Lexed]:
    """Returns the non-empty statements of a text, the first with the tokens `before` put first."""
    lexer = _Lexer(source)
    lexer.now.tokens += before
    lexer.run()
    return lexer.done


class _Lexer:
    def __init__(self, source: Source) -> None:
        self.source, self.text, self.parts = source, source.text, source.parts
        self.ends = {piece.start for piece in source.pieces}  # The ends of files, after newlines.
        self.done: list[Lexed] = []
        self.now = Lexed()
        # The unclosed brackets: the bracket, the token type of its closing bracket, its offset.
        self.open: list[tuple[str, str, int]] = []
        self.too_deep = False
        self.at_line_start = True
        self.tokens = 0

    def run(self) -> None:
        at, match, text = 0, _PATTERN.match, self.text
        handle = {kind: getattr(self, f"_{kind}") for kind in _PATTERN.groupindex}
        while at < len(text):
            if self.tokens > _TOKENS:
                self._error(f"the model has more than {_TOKENS} words and signs", at, at + 1)
                self.open.clear()
                break
            found = match(text, at)
            at = handle[found.lastgroup](found.group(), at)
        self._end_statement("the file ends before it")

    def _add(self, kind: str, value: object, start: int, end: int) -> int:
        self.at_line_start = False
        self.tokens += 1
        self.now.tokens.append(Token(kind, value, start_pos=start, end_pos=end))
        return end

    def _error(self, message: str, start: int, end: int, help: str = "") -> int:
        self.at_line_start = False
        self.now.errors.append(Diagnostic(message, Span(start, end), help))
        return end

    def _space(self, spelt: str, at: int) -> int:
        return at + len(spelt)

    def _newline(self, _: str, at: int) -> int:
        if not self.open or at + 1 in self.ends:
            self._end_statement("the file ends before it")
        self.at_line_start = True
        return at + 1

    def _comment(self, spelt: str, at: int) -> int:
        self.now.comment = description(spelt)
        return at + len(spelt)

    def _string(self, spelt: str, at: int) -> int:
        return self._add("STRING", spelt[1:-1], at, at + len(spelt))

    def _end_statement(self, why_open: str) -> None:
        if self.open:
            bracket, _, at = self.open[-1]
            closer = "')' or ']'" if self.open[-1][1] == "REND" else f"'{_CLOSERS[bracket]}'"
            message = f"this '{bracket}' is never closed: {why_open}"
            self._error(message, at, at + 1, f"add the {closer}")
            self.open.clear()
        if self.now.tokens or self.now.errors:
            self.done.append(self.now)
        self.now = Lexed()
        self.too_deep = False

    def _name(self, spelt: str, at: int) -> int:
        end = self._end_of_name(spelt, at + len(spelt))
        spelt = self.text[at:end]
        name = spelt if spelt.isascii() else self._spell_out(spelt, at)
        if len(name) > limits.NAME_LENGTH:
            self._error(
                f"a name of {len(name)} characters; the limit is {limits.NAME_LENGTH}", at, end
            )
            name = name[: limits.NAME_LENGTH]
        first = self.now.tokens[0].type if self.now.tokens else ""
        if first == "USE" and not self.open and name == _USE.get(len(self.now.tokens)):
            return self._add(name.upper(), name, at, end)
        if first in _OF_BODIES and not self.open and self._is_clause(name):
            return self._add("WORD", name, at, end)
        if name in STATEMENTS and self._is_keyword(STATEMENTS[name], end):
            if self.at_line_start and self.open:
                self._end_statement(f"'{name}' starts a new statement")
            return self._add(name.upper(), name, at, end)
        if first in _DRAWN and not self.open and (kind := self._word_of_drawing(name, at, end)):
            return kind
        called = _BRACKET.match(self.text, end) is not None
        in_method = self.now.tokens and self.now.tokens[0].type == "METHOD"
        if in_method and name == TABLEAU and len(self.now.tokens) == 2:
            return self._file(self._add("TABLEAU", name, at, end))
        if name in BEHIND.get(first, ()) and self.now.tokens[-1].type in _VALUE_ENDS | _WORD_ENDS:
            return self._add(name.upper(), name, at, end)
        if name in CLAUSE_WORDS and not (name == "step" and called and not in_method):
            return self._add(name.upper(), name, at, end)
        if called:
            return self._add("SUM" if name == "sum" else "FUNCTION", name, at, end)
        return self._add("NAME", name, at, end)

    def _end_of_name(self, name: str, end: int) -> int:
        """Returns the end of a name that begins with names of parts."""
        source = self.source
        while more := _MORE.match(self.text, end):
            if not source.dotted and source.piece(end).part + name not in self.parts:
                break
            name, end = name + more[0], more.end()
        return end

    def _is_keyword(self, row: Statement, end: int) -> bool:
        if row.before_name:
            found = _NAMED.match(self.text, end)
            return self.at_line_start and found is not None and found[1] not in CLAUSE_WORDS
        return not (row.soft and self.now.tokens)

    def _file(self, at: int) -> int:
        """Reads the path of a file, up to the next space."""
        found = _PATH.match(self.text, at)
        if found:
            return self._add("FILE", found[1], found.start(1), found.end())
        help = "e.g. method mine tableau mine.tab"
        return self._error(f"'{TABLEAU}' names no file", at - len(TABLEAU), at, help)

    def _word_of_drawing(self, name: str, at: int, end: int) -> int:
        """Reads a name in a drawing as the word of a shape or of a clause, and returns the end of
        the word. Returns 0 if the name is none of these words, but a name of the model."""
        word, *more = self.now.tokens
        shapes = shapes_of(str(word))
        if not more and self.now.errors:
            return 0  # The word after `draw` or `view` was no shape: this was reported.
        if not more:
            if name in shapes:
                return self._add("SHAPE", name, at, end)
            message = f"'{name}' is nothing that can be {'drawn' if word == 'draw' else 'viewed'}"
            return self._error(message, at, end, unknown_shape(str(word), name))
        shape = shapes[str(more[0])] if more[0].type == "SHAPE" else None
        bare = shape is not None and (not shape.subject or shape.subject_optional)
        if more[-1].type in _VALUE_ENDS or (len(more) == 1 and bare and name in shape.parts):
            return self._add("WORD", name, at, end)
        return 0

    def _is_clause(self, name: str) -> bool:
        """Whether a name in `body` or `joint` starts a clause: it does after a complete value, or
        directly after the kind of a joint without an axis."""
        before = self.now.tokens[-1]
        words = sum(token.type == "WORD" for token in self.now.tokens)
        of_joint = self.now.tokens[0].type == "JOINT" and before.type == "WORD"
        kind = of_joint and words == WORDS_TO_KIND
        return before.type in _VALUE_ENDS or (kind and name in CLAUSES["joint"])

    def _spell_out(self, spelt: str, at: int) -> str:
        letters: list[str] = []
        junk = False
        for i, character in enumerate(spelt):
            letter = character if character.isascii() else greek(character)
            if letter is None:
                if not junk:
                    self._stray(character, at + i, "a name")
                junk, letter = True, "_"
            letters.append(letter)
        return "".join(letters)

    def _stray(self, character: str, at: int, where: str) -> None:
        message, help = stray_character(character, where)
        self._error(message, at, at + 1, help)

    def _number(self, spelt: str, at: int) -> int:
        end = at + len(spelt)
        text = self.text
        following = text[end : end + 1]
        if following == "." and text[end : end + 2] != "..":
            point = re.compile(r"\.[0-9]*(?:[eE][+-]?[0-9]+)?").match(text, end)
            whole = spelt + point.group()
            if "." in spelt or "e" in spelt.lower():
                return self._error(f"'{whole}' is not a number", at, point.end())
            message = f"a number has digits on both sides of its point: '{whole}'"
            help = f"write {spelt}.0{point.group()[1:]}"
            return self._error(message, at, point.end(), help)
        if following.isalpha() or following == "_":
            word = _PATTERN.match(text, end).group()
            unit = bare_unit(text, end)
            help = bracketed(spelt, unit) if unit else f"a product is written {spelt}*{word}"
            message = f"'{spelt}{word}' is neither a number nor a name"
            self._error(message, at, end + len(word), help)
        value = literal_value(spelt)
        if isinstance(value, str):
            return self._error(value, at, end)
        return self._add("NUMBER", value, at, end)

    def _component(self, spelt: str, at: int) -> int:
        end = at + len(spelt)
        if spelt in _AXES:
            return self._add("COMPONENT", _AXES[spelt], at, end)
        if spelt[1:] in MEMBERS:
            return self._add("POINT" if spelt == ".point" else "MEMBER", spelt, at, end)
        help = "a vector has .x, .y and .z"
        if self.now.tokens and self.now.tokens[0].type in ("TABLE", "USE"):
            help = "the name of a file stands in quotes"
        if self.text[:at].endswith(("np", "math", "numpy", "sympy", "sp", "Math", "std")):
            help = f"functions have no prefix: write {spelt[1:]}"
        return self._error(f"'{spelt}' is not a component", at, end, help)

    def _operator(self, spelt: str, at: int) -> int:
        if spelt in "([":
            return self._open(spelt, at)
        if spelt in ")]":
            return self._close(spelt, at)
        return self._add(_OPERATORS[spelt], spelt, at, at + len(spelt))

    def _open(self, bracket: str, at: int) -> int:
        previous = self.now.tokens[-1] if self.now.tokens else None
        if previous is not None and previous.type == "IN":
            return self._push(bracket, "LEND", "REND", at)
        if bracket == "(":
            return self._push(bracket, "LPAREN", "RPAREN", at)
        return self._open_square(previous, at)

    def _open_square(self, previous: Token | None, at: int) -> int:
        """Opens an index if `[` touches a name, a unit if it follows a value, else a vector."""
        touches = previous is not None and previous.end_pos == at
        if previous is not None and previous.type == "NAME" and touches:
            return self._push("[", "LINDEX", "RBRACKET", at)
        if previous is None or previous.type not in _VALUE_ENDS:
            return self._push("[", "LVECTOR", "RBRACKET", at)
        unit = _UNIT.match(self.text, at)
        if unit is None:
            help = "an index touches its name: q[i]; a unit is written [m/s^2]"
            self._error("this '[' opens a unit that does not end on its line", at, at + 1, help)
            end = self.text.find("\n", at)
            return len(self.text) if end < 0 else end
        return self._add("UNIT", unit.group(1), at, unit.end())

    def _push(self, bracket: str, kind: str, closer: str, at: int) -> int:
        self.open.append((bracket, closer, at))
        if len(self.open) <= limits.DEPTH:
            return self._add(kind, bracket, at, at + 1)
        if not self.too_deep:
            self._error(f"brackets within brackets, more than {limits.DEPTH} deep", at, at + 1)
        self.too_deep = True
        return at + 1

    def _close(self, bracket: str, at: int) -> int:
        if not self.open:
            return self._error(f"this '{bracket}' closes nothing", at, at + 1)
        opener, kind, _ = self.open.pop()
        if kind != "REND" and _CLOSERS[opener] != bracket:
            message = f"this '{bracket}' cannot close the '{opener}' before it"
            self._error(message, at, at + 1, f"the '{opener}' needs a '{_CLOSERS[opener]}'")
        if self.too_deep:
            return at + 1
        return self._add(kind, bracket, at, at + 1)

    def _other(self, _: str, at: int) -> int:
        text = self.text
        if text[at] == "." and text[at + 1 : at + 2].isdigit():
            digits = re.compile(r"\.[0-9]*").match(text, at).group()
            message = f"a number has digits on both sides of its point: '{digits}'"
            return self._error(message, at, at + len(digits), f"write 0{digits}")
        self._stray(text[at], at, "a model")
        return at + 1


def literal_value(spelt: str) -> Fraction | str:
    """Returns a literal's exact value, or an error text; never computes a huge power."""
    digits, _, exponent = spelt.lower().partition("e")
    if len(digits) > limits.LITERAL_DIGITS:
        return f"a number of {len(digits)} digits; the limit is {limits.LITERAL_DIGITS}"
    if exponent and (len(exponent) > 6 or abs(int(exponent)) > limits.LITERAL_EXPONENT):
        return f"an exponent beyond {limits.LITERAL_EXPONENT}: no double holds this number"
    value = Fraction(spelt)
    try:
        rounded = float(value)
    except OverflowError:
        return "this number is too large for a double"
    return limits.lost(value, rounded, "number") or value
