"""The text of a model, positions in it, and diagnostics.

Every stage reports errors and warnings as `Diagnostic`; a stage that cannot continue raises
`ModelError` with all the diagnostics it found. The command line prints them.
"""

from __future__ import annotations

import hashlib
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import field

from .record import record


@record
class Span:
    """A half-open range of character offsets into `Source.text`."""

    start: int
    end: int

    def to(self, other: Span) -> Span:
        """The range from the start of this span to the end of `other`."""
        return Span(self.start, other.end)


@record
class Source:
    """A model's text, without a byte-order mark and with "\\n" line ends. The first `own`
    characters are from the file, the rest is from the command line (None: all are from the file).
    """

    path: str
    text: str
    own: int | None = None
    options: str = "command line"  # shown as the position of text from the command line
    _line_starts: list[int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        starts = [0]
        starts.extend(i + 1 for i, c in enumerate(self.text) if c == "\n")
        object.__setattr__(self, "_line_starts", starts)

    @property
    def sha256(self) -> str:
        """The digest of the file's text, by which generated files identify their source."""
        return hashlib.sha256(self.text[: self.own].encode()).hexdigest()

    def with_options(self, scene: str, clauses: Iterable[str]) -> Source:
        """Returns the source with the command line's clauses appended as a scene named `scene`."""
        more = "\n".join(("", f"scene {scene}", *clauses, "end", ""))
        return Source(self.path, self.text + more, len(self.text))

    def written(self, span: Span) -> str:
        """Returns the text of a span, on one line."""
        return " ".join(self.text[span.start : span.end].split())

    def is_option(self, offset: int) -> bool:
        return self.own is not None and offset > self.own

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column of an offset, both counted from 1; columns count characters."""
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def place(self, span: Span) -> str:
        if self.is_option(span.start):
            return self.options
        line, column = self.position(span.start)
        return f"{self.path}:{line}:{column}"

    def line(self, number: int) -> str:
        """The text of a line (counted from 1), without its newline."""
        start = self._line_starts[number - 1]
        end = self.text.find("\n", start)
        return self.text[start:] if end < 0 else self.text[start:end]


@record
class Diagnostic:
    """One error or warning: message, position, and a hint how to fix it."""

    message: str
    span: Span
    help: str = ""
    severity: str = "error"  # or "warning"

    def text(self, source: Source) -> str:
        """Returns the text for a person: position, message, the line with a caret, the hint."""
        line, column = source.position(self.span.start)
        shown, caret_at = _clip(_printable(source.line(line)), column - 1)
        length = max(1, min(self.span.end - self.span.start, len(shown) - caret_at))
        number = "" if source.is_option(self.span.start) else line
        lines = [
            f"{source.place(self.span)}: {self.severity}: {self.message}",
            f"{number:5} | {shown}",
            f"      | {' ' * caret_at}{'^' * length}",
        ]
        if self.help:
            lines.append(f"   help: {self.help}")
        return "\n".join(lines)

    def record(self, source: Source) -> dict[str, object]:
        """Returns the diagnostic as JSON data for `--json`."""
        line, column = source.position(self.span.start)
        return {
            "severity": self.severity,
            "message": self.message,
            "file": source.path,
            "line": line,
            "column": column,
            "help": self.help,
        }


class ModelError(Exception):
    """The model is wrong: the diagnostics of the failed stage; `more` counts those not included."""

    def __init__(self, source: Source, diagnostics: list[Diagnostic], more: int = 0):
        super().__init__()
        self.source = source
        self.diagnostics = sorted(diagnostics, key=lambda d: d.span.start)
        self.more = more

    def __str__(self) -> str:
        return self.text()

    def text(self) -> str:
        lines = [d.text(self.source) for d in self.diagnostics]
        if self.more:
            lines.append(f"{self.source.path}: and {self.more} more errors")
        return "\n".join(lines)


def _printable(line: str) -> str:
    """Returns the line with each tab or control character replaced by one column."""
    return "".join(c if c.isprintable() else " " if c == "\t" else "?" for c in line)


def _clip(line: str, at: int, width: int = 96) -> tuple[str, int]:
    """Returns a window of a long line around column `at`, and the index of this column in it."""
    if len(line) <= width:
        return line, at
    start = max(0, min(at - width // 2, len(line) - width))
    return line[start : start + width], at - start
