"""Expressions that are written as text of the language."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import lru_cache

from ...source import Piece, Source, Span
from ...tree import Expr, Name, replaced
from ..parse import parse_all


def written(text: str, span: Span, *parts: Expr, pieces: tuple[Piece, ...] = ()) -> Expr:
    """Returns the expression `text` at the position `span`, in which a, b, c, … stand for `parts`.
    It may have names of the parts of a model in `pieces`."""
    made, known = _moved(_parsed(text, pieces), span), dict(zip("abcdefgh", parts, strict=False))
    return replaced(made, lambda x: known.get(x.id) if isinstance(x, Name) else None)


@lru_cache
def _parsed(text: str, pieces: tuple[Piece, ...]) -> Expr:
    text = f"let made = {text}\n"
    parts = tuple(replace(piece, start=len(text) + 1) for piece in pieces)
    return parse_all.__wrapped__(Source("", text, parts)).statements[0].value


def _moved(part: object, span: Span) -> object:
    """Returns an expression, or a part of it, with all its source positions replaced by `span`."""
    if isinstance(part, Span):
        return span
    if isinstance(part, tuple):
        return tuple(_moved(item, span) for item in part)
    if isinstance(part, Expr):
        return replace(part, **{f.name: _moved(getattr(part, f.name), span) for f in fields(part)})
    return part
