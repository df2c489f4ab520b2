"""The text of a model, positions in it, and diagnostics.

Every stage reports errors and warnings as `Diagnostic`; a stage that cannot continue raises
`ModelError` with all the diagnostics it found. The command line prints them.
"""

from __future__ import annotations

import hashlib
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import field, replace

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
class Piece:
    """A piece of a text that comes from elsewhere than the model's own file: the file of a part, or
    clauses from the command line, which have no `part`."""

    start: int  # Offset of its first character.
    path: str  # The file, or what stands in its place in messages.
    part: str = ""  # What the names of the part begin with, such as "left." or "left.gear.".
    use: int = 0  # Offset of the statement that uses the part.


@record
class Source:
    """A model's text, without a byte-order mark and with "\\n" line ends. Behind the text of
    its own file stand those of its parts and clauses from the command line, as `pieces`. With
    `dotted`, a dot always continues a name; else only behind the name of a part."""

    path: str
    text: str
    pieces: tuple[Piece, ...] = ()
    dotted: bool = False
    _line_starts: list[int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        starts = [0]
        starts.extend(i + 1 for i, c in enumerate(self.text) if c == "\n")
        object.__setattr__(self, "_line_starts", starts)

    @property
    def sha256(self) -> str:
        """The digest of the files' text, by which generated files identify their source."""
        options = (piece.start for piece in self.pieces if not piece.part)
        return hashlib.sha256(self.text[: next(options, None)].encode()).hexdigest()

    @property
    def parts(self) -> frozenset[str]:
        """The names of all parts, such as "left" and "left.gear"."""
        return frozenset(piece.part[:-1] for piece in self.pieces if piece.part)

    def piece(self, offset: int) -> Piece:
        """The piece that has an offset; of the file's own text one from 0 on."""
        at = bisect_right(self.pieces, offset, key=lambda piece: piece.start)
        return self.pieces[at - 1] if at else Piece(0, self.path)

    def order(self, offset: int) -> tuple[int, ...]:
        """A key that sorts offsets by the order of statements: those of a part stand where it is
        used."""
        piece = self.piece(offset)
        return (*self.order(piece.use), offset) if piece.part else (offset,)

    def with_options(self, scene: str, clauses: Iterable[str]) -> Source:
        """Returns the source with the command line's clauses appended as a scene named `scene`."""
        return self.with_lines("\n".join((f"scene {scene}", *clauses, "end", "")))

    def with_lines(self, more: str) -> Source:
        """Returns the source with lines of the command line appended."""
        options = Piece(len(self.text) + 1, "command line")
        return Source(self.path, f"{self.text}\n{more}", (*self.pieces, options))

    def with_words(self, path: str, options: str) -> Source:
        """Returns the source with another path, and another word for the command line."""
        pieces = (p if p.part else replace(p, path=options) for p in self.pieces)
        return replace(self, path=path, pieces=tuple(pieces))

    def written(self, span: Span) -> str:
        """Returns the text of a span, on one line."""
        return " ".join(self.text[span.start : span.end].split())

    def is_option(self, offset: int) -> bool:
        piece = self.piece(offset)
        return piece.start > 0 and not piece.part

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column of an offset in its file, both counted from 1; columns count
        characters."""
        line = bisect_right(self._line_starts, offset)
        first = bisect_right(self._line_starts, self.piece(offset).start)
        return line - first + 1, offset - self._line_starts[line - 1] + 1

    def place(self, span: Span) -> str:
        if self.is_option(span.start):
            return self.piece(span.start).path
        line, column = self.position(span.start)
        return f"{self.piece(span.start).path}:{line}:{column}"

    def uses(self, offset: int) -> list[str]:
        """The places where the part that has an offset is used, the innermost first."""
        piece = self.piece(offset)
        if not piece.part:
            return []
        name = piece.part[:-1].rpartition(".")[2]
        return [f"{self.place(Span(piece.use, piece.use))} as {name}", *self.uses(piece.use)]

    def line(self, offset: int) -> str:
        """The text of the line that has an offset, without its newline."""
        start = self._line_starts[bisect_right(self._line_starts, offset) - 1]
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
        shown, caret_at = _clip(_printable(source.line(self.span.start)), column - 1)
        length = max(1, min(self.span.end - self.span.start, len(shown) - caret_at))
        number = "" if source.is_option(self.span.start) else line
        lines = [
            f"{source.place(self.span)}: {self.severity}: {self.message}",
            f"{number:5} | {shown}",
            f"      | {' ' * caret_at}{'^' * length}",
        ]
        if self.help:
            lines.append(f"   help: {self.help}")
        lines += [f"   used at {place}" for place in source.uses(self.span.start)]
        return "\n".join(lines)

    def record(self, source: Source) -> dict[str, object]:
        """Returns the diagnostic as JSON data for `--json`."""
        line, column = source.position(self.span.start)
        piece = source.piece(self.span.start)
        uses = {"used_at": source.uses(self.span.start)} if piece.part else {}
        return {
            "severity": self.severity,
            "message": self.message,
            "file": piece.path if piece.part else source.path,
            "line": line,
            "column": column,
            "help": self.help,
            **uses,
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
