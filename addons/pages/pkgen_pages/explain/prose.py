"""Typesets the names and formulas of a model in sentences about it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from html import escape

from pkgen.front import parse
from pkgen.source import Source

from . import mathml
from .mathml import fraction, operator, row
from .written import Written

_WORD = re.compile(r"[A-Za-z]{2,}")  # A name of this form may also be an English word.
TERMS = 12  # Most terms of a sum that is shown in full.
_ARTICLES = frozenset("aAI")  # English words of one letter, never typeset as names.
_SHIFT = re.compile(r"(^| [+-] )(.*?)d/d(\S+)")


class Prose:
    def __init__(self, written: Written, names: Iterable[str], formulas: Iterable[str] = ()):
        """`names` are the model's names; `formulas` are expressions that occur in sentences."""
        self.written = written
        self.formulas = {text: self.formula(text) for text in formulas}
        names = [n for n in names if not _WORD.fullmatch(n) or mathml.is_greek(n)]
        self.names = {n: written.name(n) for n in names if n not in _ARTICLES}
        known = sorted({*self.formulas, *self.names}, key=len, reverse=True)
        self._known = re.compile(
            "|".join(rf"(?<![\w.\]]){re.escape(x)}(?![\w\[(']|\.\w)" for x in known) or "(?!)"
        )

    def __call__(self, text: str) -> str:
        """Returns a sentence as HTML, with its names and formulas typeset."""
        parts, last = [], 0
        for found in self._known.finditer(text):
            parts += [escape(text[last : found.start()]), mathml.inline(self._typeset(found[0]))]
            last = found.end()
        return "".join([*parts, escape(text[last:])])

    def _typeset(self, text: str) -> str:
        return self.formulas.get(text) or self.names[text]

    def formula(self, text: str) -> str:
        """Returns an expression of the modelling language typeset; other text is kept."""
        file = parse.parse_all(Source("", f"model m\nlet y = {text}\n"))
        if file.diagnostics or len(file.statements) != 2:
            return mathml.words(text)
        return self.written(file.statements[1].value)

    def unit(self, unit: str) -> str:
        return escape(mathml.unit_text(unit))

    def generator(self, text: str) -> str:
        """Returns a symmetry generator like "x d/dy - y d/dx" typeset, with partial derivatives."""
        terms = [(sign.strip(), *rest) for sign, *rest in _SHIFT.findall(text)]
        if len(terms) > TERMS:
            terms = [*terms[:2], ("+", "", ""), terms[-1]]
        parts = []
        for sign, before, name in terms:
            before = before.strip()
            if before.startswith("-"):
                sign, before = "-" if sign != "-" else "+", before[1:]
            shown = _partial(name) if name else operator("…")
            if before:
                shown = mathml.product([self.formula(before), shown])
            parts.append(
                (
                    mathml.binary(sign or "+")
                    if parts
                    else mathml.leading("-")
                    if sign == "-"
                    else ""
                )
                + shown
            )
        return " ".join(map(mathml.inline, parts))


def _partial(name: str) -> str:
    partial = operator("∂")
    return fraction(partial, row(partial, mathml.name(name)), small=True)
