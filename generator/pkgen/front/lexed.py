"""The output of the lexer: a statement's tokens, and its trailing comment as plain text."""

from __future__ import annotations

from dataclasses import dataclass, field

from lark.lexer import Token

from ..source import Diagnostic, Span
from .table import STATEMENTS

_DESCRIPTION_LENGTH = 200


@dataclass
class Lexed:
    """The tokens of a statement; `comment` is the last comment at the end of one of its lines."""

    tokens: list[Token] = field(default_factory=list)
    comment: str = ""
    errors: list[Diagnostic] = field(default_factory=list)

    @property
    def keyword(self) -> str:
        """The keyword at the start of the statement, or ""."""
        first = self.tokens[0] if self.tokens else None
        return str(first) if first is not None and first.type.lower() in STATEMENTS else ""

    @property
    def span(self) -> Span:
        if not self.tokens:
            return self.errors[0].span
        return Span(self.tokens[0].start_pos, self.tokens[-1].end_pos)


def description(comment: str) -> str:
    """Returns a comment's text on one line, shortened, with printable characters only."""
    kept = (c if c.isprintable() else " " for c in comment.lstrip("#"))
    text = " ".join("".join(kept).split())
    if len(text) <= _DESCRIPTION_LENGTH:
        return text
    return text[: _DESCRIPTION_LENGTH - 1].rstrip() + "…"
