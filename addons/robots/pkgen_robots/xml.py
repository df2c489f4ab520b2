"""Reads XML as a tree of elements with positions. A DOCTYPE is refused, so that there are no
entities; the depth and number of elements are limited, and no function is recursive."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from xml.parsers import expat

from pkgen import limits
from pkgen.source import Diagnostic, ModelError, Source, Span

# Bounds of the magnitudes of numbers; within them, the squares are finite, normal doubles.
LARGEST, SMALLEST = 1e100, 1e-100
ANGLE = 1e6  # largest angle, in radians or degrees; a larger one would lose digits
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


@dataclass
class Element:
    source: Source
    tag: str
    attributes: dict[str, str]
    span: Span
    children: list[Element] = field(default_factory=list)
    # For an element of an included file: its position there; `span` is that of the <include>.
    where: str = ""

    def all(self, tag: str) -> Iterator[Element]:
        return (child for child in self.children if child.tag == tag)

    def first(self, tag: str) -> Element | None:
        return next(self.all(tag), None)

    def wrong(self, message: str, help: str = "") -> ModelError:
        if self.where:
            message = f"{self.where.rsplit(':', 2)[0]}: {message}"
            help = f"{self.where}{f': {help}' if help else ''}"
        return ModelError(self.source, [Diagnostic(message, self.span, help)])

    def text(self, name: str) -> str:
        """Returns a required attribute. Raises ModelError."""
        if not self.attributes.get(name, "").strip():
            raise self.wrong(f"<{self.tag}> has no '{name}'")
        return self.attributes[name].strip()

    def numbers(
        self, name: str, count: int, default: tuple[float, ...] = (), largest: float = LARGEST
    ) -> tuple[float, ...]:
        """Returns `count` finite numbers, or any number of them if `count` is 0. The attribute is
        required if there is no default. Raises ModelError."""
        if default and name not in self.attributes:
            return default
        words = self.text(name).split()
        shown = self.attributes[name][:40]
        if not all(_NUMBER.fullmatch(word) for word in words):
            raise self.wrong(f'{name}="{shown}" is no number')
        found = tuple(float(word) + 0.0 for word in words)  # -0 is 0
        if not all(abs(x) < largest for x in found):
            raise self.wrong(f'{name}="{shown}" is too large')
        small = [w for w, x in zip(words, found, strict=True) if abs(x) < SMALLEST and _spelt(w)]
        if small:
            help = f"write 0, or a number of at least {SMALLEST:g}"
            raise self.wrong(f'{name}="{shown}" is too small: {small[0][:40]} is not 0', help)
        if count and len(found) != count:
            numbers = "one number" if count == 1 else f"{count} numbers"
            raise self.wrong(f"'{name}' of <{self.tag}> is {numbers}, not {len(found)}")
        return found

    def number(self, name: str, *default: float) -> float:
        return self.numbers(name, 1, default)[0]

    def flag(self, name: str, default: bool = False) -> bool:
        """Returns whether an attribute is "true". Raises ModelError if it is not "false" either."""
        value = self.attributes.get(name, str(default).lower())
        if value not in ("true", "false"):
            raise self.wrong(f'{name}="{value[:10]}" is not true or false')
        return value == "true"


class Errors:
    """Collects the errors in a file; equal errors at several positions count as one."""

    MOST = 20  # most errors shown

    def __init__(self) -> None:
        self.found: dict[str, tuple[Diagnostic, int]] = {}

    def add(self, error: ModelError) -> None:
        for new in error.diagnostics:
            first, count = self.found.get(new.message, (new, 0))
            self.found[new.message] = first, count + 1

    @contextmanager
    def collecting(self) -> Iterator[None]:
        try:
            yield
        except ModelError as error:
            self.add(error)

    def stop(self, source: Source) -> None:
        """Raises ModelError if there are errors."""
        if not self.found:
            return
        all_ = [
            replace(first, message=first.message + (f" ({count} times)" if count > 1 else ""))
            for first, count in self.found.values()
        ]
        raise ModelError(source, all_[: self.MOST], max(0, len(all_) - self.MOST))


def _spelt(word: str) -> bool:
    """Whether a number as written has a digit other than 0. The value of such a number may still
    underflow to 0."""
    return any(digit in "123456789" for digit in word.lower().partition("e")[0])


def tree(source: Source) -> Element:
    """Returns the root element. Raises ModelError with the position of an error."""
    lines = [0]
    lines += [k + 1 for k, c in enumerate(source.text) if c == "\n"]
    parser = expat.ParserCreate("utf-8")
    open_now: list[Element] = []
    roots: list[Element] = []
    count = 0

    def here(length: int = 1) -> Span:
        line = min(parser.CurrentLineNumber - 1, len(lines) - 1)
        at = min(lines[line] + parser.CurrentColumnNumber, max(len(source.text) - 1, 0))
        return Span(at, min(at + length, len(source.text)))

    def stop(message: str, help: str = "") -> None:
        raise ModelError(source, [Diagnostic(message, here(), help)])

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > limits.XML_ELEMENTS:
            stop(f"more than {limits.XML_ELEMENTS} elements")
        if len(open_now) >= limits.XML_DEPTH:
            stop(f"elements within elements, more than {limits.XML_DEPTH} deep")
        element = Element(source, tag, attributes, here(1 + len(tag)))
        (open_now[-1].children if open_now else roots).append(element)
        open_now.append(element)

    def doctype(*_: object) -> None:
        stop("a document type is refused: it can declare entities", "take the DOCTYPE out")

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: open_now.pop()
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(source.text.encode("utf-8"), True)
    except expat.ExpatError as error:
        stop(f"this is no XML: {expat.errors.messages.get(error.code, 'it is broken')}")
    return roots[0]
