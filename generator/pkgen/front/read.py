"""Reads a model file into a Source, or raises an error that says why it cannot be read."""

from __future__ import annotations

import os
import re
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from difflib import get_close_matches
from functools import cache

from .. import limits
from ..source import Diagnostic, ModelError, Piece, Source, Span

READ: dict[str, None] = {}  # The files read so far, in order. Output files depend on them.
_ALLOWED: ContextVar[tuple[str, ...]] = ContextVar("allowed", default=())
STANDARD = "-"  # The path that means standard input.


class UnreadableModel(ModelError):
    """The file cannot be read; the error refers to the file, not to a line in it."""

    def text(self) -> str:
        lines = []
        for d in self.diagnostics:
            lines.append(f"{self.source.path}: error: {d.message}")
            if d.help:
                lines.append(f"   help: {d.help}")
        return "\n".join(lines)


def read(path: str | os.PathLike[str]) -> Source:
    """Returns the text of a model with those of its parts, else as read_text()."""
    return with_parts(read_text(path, "a .lag file"))


def read_text(path: str | os.PathLike[str], what: str) -> Source:
    """Returns the text of a UTF-8 file, or of standard input for "-", without byte-order mark and
    with normalized line ends; `what` says in messages which file is needed. Raises UnreadableModel,
    or ModelError for an error in the text."""
    shown = os.fspath(path)
    if shown == STANDARD:
        shown, data = "<stdin>", _standard_input()
    else:
        data = _bytes(shown, what)
        READ[shown] = None
    if len(data) > limits.FILE_BYTES:
        raise _unreadable(shown, f"the file is larger than {limits.FILE_BYTES:,} bytes")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        message = f"line {line} is not UTF-8 text (byte {error.start}, 0x{data[error.start]:02X})"
        help = "save the file with the encoding UTF-8"
        if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
            message, help = "the file is UTF-16 text", "save it with the encoding UTF-8"
        raise _unreadable(shown, message, help) from None
    return from_text(shown, text)


USE = re.compile(  # The statement `use`, up to the name of the part.
    r'^[ \t]*use[ \t]*"([^"\n]*)"[ \t]*as[ \t]+([A-Za-z_]\w*)(\[)?', re.A | re.M
)


def with_parts(source: Source) -> Source:
    """Returns the text of a model followed by the texts of the parts that it uses, and of theirs.
    Raises ModelError for a part that cannot be read."""
    texts, pieces = [source.text], [Piece(0, source.path)]
    chains = {"": [source.path]}  # name of a part -> its file, before it those that use it
    size = len(source.text)

    def wrong(message: str, span: Span, help: str = "") -> ModelError:
        known = Source(source.path, "\n".join(texts), tuple(pieces[1:]))
        return ModelError(known, [Diagnostic(message, span, help)])

    for piece, text in zip(pieces, texts, strict=False):  # Both grow.
        for found in USE.finditer(text):
            name, at = found[1], piece.start + found.start(1)
            named, span = Span(at - 1, at + len(name) + 1), Span(at - 1, piece.start + found.end(2))
            part, chain = f"{piece.part}{found[2]}.", chains[piece.part]
            path, why = beside(piece.path, name)
            if found[3]:
                help = f'write them out: use "{name}" as {found[2]}1, then as {found[2]}2, …'
                raise wrong("there are no families of parts", span, help)
            if part in chains:
                raise wrong(f"there is a part '{part[:-1]}' already", span, "choose another name")
            if len(part) > limits.NAME_LENGTH:
                message = f"'{part[:-1]}' has {len(part) - 1} characters"
                raise wrong(f"{message}; the limit is {limits.NAME_LENGTH}", span)
            if len(pieces) > limits.PARTS:
                raise wrong(f"the model has more than {limits.PARTS:,} parts", span)
            if why:
                raise wrong(why, named, "copy it there, and name it from there")
            if os.path.realpath(path) in map(os.path.realpath, chain):
                raise wrong(f"'{name}' uses itself: {' uses '.join((*chain, path))}", named)
            try:
                texts.append(read_text(path, "a .lag file").text)
            except ModelError as error:
                (cause,) = error.diagnostics
                raise wrong(f"{path}: {cause.message}", named, cause.help) from None
            pieces.append(Piece(size + 1, path, part, piece.start + found.start(0)))
            chains[part] = [*chain, path]
            size += 1 + len(texts[-1])
            if size > limits.FILE_BYTES:
                raise wrong(f"the model and its parts are larger than {limits.FILE_BYTES:,}", span)
    return Source(source.path, "\n".join(texts), tuple(pieces[1:]))


def beside(user: str, name: str) -> tuple[str, str]:
    """Returns the path of the file that the model file `user` calls `name`, and why it may not use
    this file, or "". It may use files in its own folder and in those below."""
    folder = os.path.dirname(user)
    path = os.path.join(folder, name)
    if os.path.isabs(name) or not inside(path, folder):
        return path, f"'{name}' lies outside of the folder of the file that names it"
    return path, ""


@contextmanager
def allowing(*folders: str | os.PathLike[str]) -> Iterator[None]:
    """Within the context, models and plans may also refer to files in these folders."""
    token = _ALLOWED.set((*_ALLOWED.get(), *map(os.path.realpath, folders)))
    try:
        yield
    finally:
        _ALLOWED.reset(token)


def inside(path: str | os.PathLike[str], *folders: str | os.PathLike[str]) -> bool:
    """Whether a file lies in one of the folders, after all links are resolved."""
    try:
        place = os.path.realpath(path)
    except ValueError:  # The path contains a NUL.
        return False
    return any(os.path.commonpath((place, f)) == f for f in map(os.path.realpath, folders))


def refusal(named: str, path: str | os.PathLike[str], *folders: str | os.PathLike[str]) -> str:
    """Returns why a model or plan may not refer to the file, or "" if it may."""
    if inside(path, *folders, *_ALLOWED.get()):
        return ""
    return f"'{named}' lies outside of the folder of the file that names it"


ALLOW = "copy it there, or allow its folder: --allow-path DIR"


def unquoted(path: str | os.PathLike[str], wrong: ModelError) -> tuple[str, str]:
    """Returns the message and hint for an error in a tableau file outside the model's folder. They
    quote nothing from the file."""
    line, column = wrong.source.position(wrong.diagnostics[0].span.start)
    return f"{path}:{line}:{column}: this is no tableau", f"see: pkgen methods --tableau {path}"


def from_text(path: str, text: str) -> Source:
    """Returns the Source of a text; raises ModelError for a NUL character."""
    source = Source(path, text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n"))
    nul = source.text.find("\0")
    if nul >= 0:
        message = "a NUL character: this is not a text file"
        raise ModelError(source, [Diagnostic(message, Span(nul, nul + 1))])
    return source


def _bytes(path: str, wanted: str) -> bytes:
    try:
        # The kind of file is checked before the file is opened: opening a pipe would block, and a
        # device might never end.
        if not stat.S_ISREG(os.stat(path).st_mode):
            what = "a directory" if os.path.isdir(path) else "not a regular file"
            raise _unreadable(path, f"this is {what}", f"give the path of {wanted}")
        with open(path, "rb") as file:
            return file.read(limits.FILE_BYTES + 1)
    except FileNotFoundError:
        raise _unreadable(path, "there is no such file", _similar(path)) from None
    except (OSError, ValueError) as error:  # ValueError: the path contains a NUL
        reason = getattr(error, "strerror", None) or str(error)
        raise _unreadable(path, f"cannot read it: {reason}") from None


@cache  # Standard input can be read only once.
def _standard_input() -> bytes:
    if sys.stdin is None:
        raise _unreadable(STANDARD, "the standard input is closed")
    return sys.stdin.buffer.read(limits.FILE_BYTES + 1)


def _similar(path: str) -> str:
    if os.path.isfile(path + ".lag"):
        return f"did you mean {path}.lag?"
    folder, name = os.path.split(path)
    with suppress(OSError):
        models = [x for x in os.listdir(folder or ".")[:1000] if x.endswith(".lag")]
        near = get_close_matches(name, models, 1)
        return f"did you mean {os.path.join(folder, near[0])}?" if near else ""
    return ""


def _unreadable(path: str, message: str, help: str = "") -> UnreadableModel:
    return UnreadableModel(Source(path, ""), [Diagnostic(message, Span(0, 0), help)])
