"""Reads a Runge-Kutta tableau file: the rows of A, the weights b, optionally embedded weights.

    A            # row by row; missing numbers at the end of a row are 0
    0
    1/2
    0 1/2
    0 0 1
    b 1/6 1/3 1/3 1/6
    bhat ...     # optional: embedded weights for the error estimate and adaptive steps

Numbers are decimals or fractions, and stay exact. They are matched by a pattern, never evaluated
as code. The nodes c are the row sums of A.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction

from ..record import record
from ..source import Diagnostic, ModelError, Source, Span

# Most stages of a tableau in a file. For runs the limit is PK_MOST_STAGES of pk/step/tableau.h.
MOST_STAGES = 64
MOST_TEXT = 200_000
LARGEST, SMALLEST = 10**6, Fraction(1, 10**40)
MOST_ERRORS = 5

_WORD = re.compile(r"[^\s,#]+")
_DECIMAL = r"(?:[0-9]{1,60}(?:\.[0-9]{0,60})?|\.[0-9]{1,60})"
_NUMBER = re.compile(rf"([+-]?{_DECIMAL})(?:[eE]([+-]?[0-9]{{1,2}}))?")
_FRACTION = re.compile(r"([+-]?[0-9]{1,60})/([0-9]{1,60})")
SECTIONS = ("A", "b", "bhat")
FORM = "a number is 0.25, 2.5e-1 or 1/4"


@record
class Tableau:
    source: Source
    a: tuple[tuple[Fraction, ...], ...]  # square
    b: tuple[Fraction, ...]
    bhat: tuple[Fraction, ...] | None

    @property
    def stages(self) -> int:
        return len(self.b)

    @property
    def c(self) -> tuple[Fraction, ...]:
        return tuple(sum(row, Fraction(0)) for row in self.a)

    @property
    def kind(self) -> str:
        """Returns the class of the method: explicit, diagonally implicit or fully implicit."""
        above = [(i, j) for i, row in enumerate(self.a) for j, x in enumerate(row) if x and j >= i]
        if not above:
            return "explicit"
        if all(i == j for i, j in above):
            return "diagonally implicit"
        return "fully implicit"


class NotANumber(ValueError):
    """A text is not a valid number; it has a message and a hint."""

    def __init__(self, message: str, help: str = FORM):
        super().__init__(message)
        self.help = help


def number(text: str) -> Fraction:
    """Parses a decimal or a fraction. Raises NotANumber."""
    shown = text if len(text) <= 40 else text[:40] + "…"
    if found := _FRACTION.fullmatch(text):
        if int(found[2]) == 0:
            raise NotANumber(f"{shown} divides by zero")
        value = Fraction(int(found[1]), int(found[2]))
    elif found := _NUMBER.fullmatch(text):
        value = Fraction(found[1]) * Fraction(10) ** int(found[2] or 0)
    else:
        raise NotANumber(f"'{shown}' is no number")
    if abs(value) > LARGEST:
        raise NotANumber(f"{shown} is too large for a coefficient", f"{LARGEST:,} at most")
    if value and abs(value) < SMALLEST:
        raise NotANumber(f"{shown} is too small for a coefficient", "write 0")
    return value


def read_tableau(source: Source) -> Tableau:
    """Parses a tableau file. Raises ModelError, which shows where the errors are."""
    return _Reader(source).tableau()


class _Reader:
    def __init__(self, source: Source):
        self.source = source
        self.errors: list[Diagnostic] = []
        self.rows: dict[str, list[list[Fraction]]] = {}
        self.places: dict[str, list[Span]] = {}  # section -> positions of its name and rows

    def error(self, message: str, span: Span, help: str = "") -> None:
        self.errors.append(Diagnostic(message, span, help))

    def fail_on_errors(self) -> None:
        if self.errors:
            most = MOST_ERRORS
            raise ModelError(self.source, self.errors[:most], max(0, len(self.errors) - most))

    def tableau(self) -> Tableau:
        text = self.source.text
        if len(text) > MOST_TEXT:
            self.error(
                f"a tableau of {len(text):,} characters", Span(0, 1), f"{MOST_TEXT:,} at most"
            )
            self.fail_on_errors()
        section = ""
        for words in _lines(text):
            if len(self.errors) >= MOST_ERRORS:
                break
            section = self._line(section, words)
        self.fail_on_errors()
        self._whole()
        self.fail_on_errors()
        s = len(self.rows["b"][0])
        zero = Fraction(0)
        a = tuple((*row, *[zero] * (s - len(row))) for row in self.rows["A"])
        bhat = tuple(self.rows["bhat"][0]) if "bhat" in self.rows else None
        return Tableau(self.source, a, tuple(self.rows["b"][0]), bhat)

    def _line(self, section: str, words: list[tuple[str, Span]]) -> str:
        """Parses a line, which may begin a new section; returns the section of the next line."""
        word, span = words[0]
        name = word.removesuffix(":")
        if name in SECTIONS:
            if name in self.rows:
                self.error(f"a second '{name}'", span, "each section is there once")
            section = name
            self.rows[section], self.places[section] = [], [span]
            words = words[1:]
        if not words:
            return section
        if not section:
            help = "begin with a line A, the rows of the matrix under it"
            self.error(f"'{word[:40]}' stands before any section", span, help)
            return section
        row = []
        for text, at in words:
            try:
                row.append(number(text))
            except NotANumber as wrong:
                self.error(str(wrong), at, wrong.help)
        whole = words[0][1].to(words[-1][1])
        if len(row) > MOST_STAGES or len(self.rows[section]) >= MOST_STAGES:
            self.error(f"more than {MOST_STAGES} stages", whole, "a method of fewer")
        elif section != "A" and self.rows[section]:
            help = "a line without a word goes on with the section above"
            self.error(f"a second row of '{section}'", whole, help)
        self.rows[section].append(row)
        self.places[section].append(whole)
        return section

    def _whole(self) -> None:
        end = len(self.source.text.rstrip())
        last = Span(max(0, end - 1), end)
        for name, what in (("A", "the matrix"), ("b", "the weights")):
            if not self.rows.get(name):
                at = self.places[name][0] if name in self.places else last
                self.error(
                    f"there is no {name}, {what} of the method", at, f"add: {name} 1/6 1/3 …"
                )
        if self.errors:
            return
        s = len(self.rows["b"][0])
        count = len(self.rows["A"])
        if count != s:
            self.error(
                f"A has {count} row{'s' * (count != 1)}, b has {s} weight{'s' * (s != 1)}",
                self.places["b"][1],
                "a row of A for each stage; the first of an explicit method is 0",
            )
        for row, place in zip(self.rows["A"], self.places["A"][1:], strict=True):
            if len(row) > s:
                message = f"a row of {len(row)} numbers in a method of {s} stages"
                self.error(message, place, "a row has a number for each stage, or fewer")
        for name in ("b", "bhat"):
            if name not in self.rows:
                continue
            if not self.rows[name]:
                self.error(f"'{name}' has no weights", self.places[name][0], FORM)
                continue
            row, place = self.rows[name][0], self.places[name][1]
            if len(row) != s:
                self.error(f"'{name}' has {len(row)} weights, b has {s}", place, "one a stage")
            elif abs(sum(row) - 1) > Fraction(1, 10**12):
                message = f"the weights '{name}' sum to {float(sum(row)):.12g}, not to 1"
                self.error(message, place, "a method of order 1 or more has weights of sum 1")
        if "bhat" in self.rows and self.rows["bhat"] == self.rows["b"]:
            message = "b and bhat are the same: their difference is to estimate the error"
            self.error(message, self.places["bhat"][1], "leave bhat out for a fixed step")


def _lines(text: str) -> Iterator[list[tuple[str, Span]]]:
    """Yields the words of each line, without comments; skips empty lines."""
    at = 0
    for line in text.split("\n"):
        kept = line.partition("#")[0]
        words = [(w[0], Span(at + w.start(), at + w.end())) for w in _WORD.finditer(kept)]
        if words:
            yield words
        at += len(line) + 1
