"""Parses a text statement by statement, so that one run reports several syntax errors.

The lexer splits the text into statements of tokens; lark's LALR parser parses each. For a broken
statement `check` gets its position and the names that it would have declared.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path

from lark import Lark
from lark import __version__ as lark_version
from lark.exceptions import UnexpectedToken
from lark.lexer import Lexer

from .. import limits
from ..source import Diagnostic, ModelError, Source, Span
from ..system.cache import cached
from ..system.exits import BuildError
from ..tree import Expr, children
from . import statements as st
from .lexed import Lexed
from .lexer import statements
from .parse_build import Build
from .parse_errors import declared_names, explain, misplaced
from .parts import Parts, prefixed
from .table import BOTH, IN_SAMPLE, MODEL, SAMPLE, STATEMENTS, grammar

GRAMMAR = Path(__file__).with_name("grammar.lark")


class _Tokens(Lexer):
    """The lexer for lark: it passes on the tokens made by `lexer.py`."""

    def __init__(self, lexer_conf: object) -> None:
        pass

    def lex(self, data):
        return iter(data)


@cache
def parser() -> tuple[Lark, Build]:
    """Returns the parser of one statement, and the object whose methods it calls to build the
    statement."""
    build = Build()
    rules = GRAMMAR.read_text(encoding="utf-8") + grammar()
    made_by = (rules, lark_version, sys.version_info[:2])
    digest = hashlib.sha256(repr(made_by).encode()).hexdigest()[:24]

    # Cached, since making the tables takes half the time of a short command. The folder is private
    # to the user; lark itself rejects tables that are broken or of another grammar.
    try:
        tables = str(cached("parser", digest, lambda _: None) / "tables")
    except BuildError:
        tables = False
    return Lark(rules, parser="lalr", lexer=_Tokens, transformer=build, cache=tables), build


def parse(source: Source) -> st.File:
    """Returns the parsed file; raises ModelError with all syntax errors."""
    file = parse_all(source)
    if file.diagnostics:
        raise ModelError(source, list(file.diagnostics))
    return file


@lru_cache(maxsize=4)  # A command may compile a file once for each of its scenes.
def parse_all(source: Source) -> st.File:
    """Returns the parsed file. It has the statements that parse, the positions and names of those
    that do not, and the errors."""
    if len(source.text) > limits.FILE_BYTES:
        message = f"the model is larger than {limits.FILE_BYTES} bytes"
        return st.File(source, (), (), (Diagnostic(message, Span(0, 1)),))
    if not source.text.strip():
        message = "the file is empty"
        hint = "a model begins with a line such as 'model pendulum'"
        return st.File(source, (), (), (Diagnostic(message, Span(0, 0), hint),))
    reader = _Reader(source)
    for number, lexed in enumerate(prefixed(source, statements(source))):
        if number == limits.STATEMENTS:
            message = f"more than {limits.STATEMENTS} statements"
            reader.errors.append(Diagnostic(message, lexed.span))
            reader.broken.append(st.Broken("", (), lexed.span))
            break
        reader.read(lexed)
    return reader.file()


class _Reader:
    """Parses statements, and joins the first line of each block, which is a scene or a sample
    block, and its clauses into one statement."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.errors: list[Diagnostic] = []
        self.broken: list[st.Broken] = []
        self.statements: list[st.Statement] = []
        self.block: st.Scene | st.Sample | None = None
        self.part = ""
        self.headless = ""  # Keyword of the current block if its first line did not parse.
        self.clauses: list[st.Statement] = []
        self.units: dict[str, None] = {}
        self.nodes = 0

    def read(self, lexed: Lexed) -> None:
        part = self.source.piece(lexed.span.start).part
        if part != self.part:
            self._end_file()
        self.part = part
        fits = self._place(lexed)
        statement = self._parse(lexed)
        if not isinstance(self.block, st.Scene):
            self.units.update((str(t), None) for t in lexed.tokens if t.type == "UNIT")
        if statement is None:
            if lexed.keyword in ("scene", "sample"):
                self.headless = lexed.keyword
            self.broken.append(st.Broken(lexed.keyword, declared_names(lexed), lexed.span))
        elif lexed.keyword in ("scene", "sample"):
            self.block = statement
        elif isinstance(statement, st.EndOfScene):
            self._close_block(statement.span)
            self.headless = ""
        elif self.block is not None and fits:
            self.clauses.append(statement)
        elif _stands_in(lexed.keyword) in (MODEL, BOTH) and not self.headless:
            self.statements.append(statement)

    def file(self) -> st.File:
        self._end_file()
        if any(s.keyword in ("use", "set") for s in self.statements):
            parts = Parts(self.source, self.statements)
            self.statements = parts.statements
            self.errors += parts.errors if not self.errors else []
            self.broken += [st.Broken("use", (), error.span) for error in parts.errors]
        found = self.statements, self.broken, self.errors, self.units
        return st.File(self.source, *map(tuple, found))

    def _end_file(self) -> None:
        self.headless = ""
        if self.block is not None:
            self._unended("the file ends before it")

    def _place(self, lexed: Lexed) -> bool:
        """Reports a block's clause outside of such blocks, or a model's statement in a block.
        Returns whether the statement stands where it may."""
        word, kind = lexed.keyword, self.block.keyword if self.block else self.headless
        where = _stands_in(word)
        fits = where in (MODEL, BOTH, "")
        if kind:
            fits = where != MODEL if kind == "scene" else word in (*IN_SAMPLE, "end", "")
        if fits and (where != SAMPLE or kind == "sample"):
            return True
        if where == SAMPLE or not kind:
            self.errors.append(misplaced(lexed))
        elif self.block is not None:
            self._unended(f"'{word}' cannot stand in a {kind}{' block' * (kind == 'sample')}")
        else:
            self.headless = ""
        return False

    def _unended(self, why: str) -> None:
        block = self.block
        what = "scene" if block.keyword == "scene" else "sample block"
        help = f"close the {what} with a line that says 'end'"
        message = f"{what} '{block.name}' has no 'end': {why}"
        self.errors.append(Diagnostic(message, block.span, help))
        self._close_block(block.span)

    def _close_block(self, span: Span) -> None:
        if self.block is not None:
            whole = self.block.span.to(span)
            self.statements.append(replace(self.block, clauses=tuple(self.clauses), span=whole))
        self.block, self.clauses = None, []

    def _parse(self, lexed: Lexed) -> object | None:
        if lexed.errors:
            self.errors.extend(lexed.errors)
            return None
        lark, build = parser()
        build.comment = lexed.comment
        try:
            statement = lark.parse(lexed.tokens)
        except UnexpectedToken as error:
            if len(self.errors) > limits.DIAGNOSTICS:  # There are too many errors to explain.
                self.errors.append(Diagnostic("a statement that does not parse", lexed.span))
            else:
                self.errors.append(explain(self.source, lexed, error))
            return None
        self.nodes, wrong = measure(statement, self.nodes)
        for name, span in _own_names(statement):
            of = name.rpartition(".")[0]
            if "." in name.removeprefix(self.part):
                of_part = of in self.source.parts
                help = "declared in its file" if of_part else "made by its joint"
                help = f"what a {'part' if of_part else 'body'} has is {help}"
                wrong = Diagnostic(f"'{name}' is no name of your own", span, help)
        if wrong is not None:
            self.errors.append(wrong)
            return None
        return statement


def _own_names(statement: object) -> Iterator[tuple[str, Span]]:
    """Yields the names that a statement declares and that its author writes."""
    for item in statement.items if isinstance(statement, st.Declare) else ():
        yield item.name, item.name_span
    if isinstance(statement, st.Event | st.Head | st.Scene | st.Use):
        yield statement.name, statement.name_span
    left = getattr(statement, "left", None)
    if left is not None and not isinstance(statement, st.Force):
        yield left.name, left.span


def _stands_in(word: str) -> str:
    return STATEMENTS[word].stands_in if word in STATEMENTS else ""


def measure(statement: object, nodes: int = 0) -> tuple[int, Diagnostic | None]:
    """Adds the number of expression nodes in a statement to `nodes`; returns the sum, and an error
    if a limit of size or depth is exceeded. Does not recurse."""
    waiting = [(e, 1) for e in _expressions(statement)]
    while waiting:
        expr, depth = waiting.pop()
        nodes += 1
        if depth > limits.DEPTH:
            message = f"an expression more than {limits.DEPTH} deep"
            return nodes, Diagnostic(message, expr.span, "use 'let'")
        if nodes > limits.NODES:
            message = f"the model has more than {limits.NODES} numbers, names and operations"
            return nodes, Diagnostic(message, expr.span)
        waiting.extend((e, depth + 1) for e in children(expr))
    return nodes, None


def _expressions(part: object):
    """Yields the outermost expressions of a statement or of a part of it."""
    if isinstance(part, Expr):
        yield part
    elif isinstance(part, tuple):
        for item in part:
            yield from _expressions(item)
    elif hasattr(part, "__dataclass_fields__"):
        for name in part.__dataclass_fields__:
            yield from _expressions(getattr(part, name))
