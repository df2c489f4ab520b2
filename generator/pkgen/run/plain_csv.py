"""Fast reader of CSV whose cells are all plain numbers, block by block."""

from __future__ import annotations

import warnings
from typing import BinaryIO

import numpy

BLOCK = 1 << 22  # bytes
ALLOWED = b"0123456789+-.eE,\n"
COMMA, END, POINT, ZERO, NINE = b",\n.09"


def blocks(file: BinaryIO, longest: int):
    """Yields blocks of whole lines that end with \\n; yields None at a line of `longest` bytes."""
    rest = b""
    while chunk := file.read(BLOCK):
        chunk = rest + chunk
        cut = chunk.rfind(b"\n") + 1
        rest = chunk[cut:]
        if len(rest) >= longest:
            yield None
            return
        if cut:
            yield chunk[:cut].replace(b"\r\n", b"\n")
    if rest:
        yield rest.removesuffix(b"\r") + b"\n"


def numbers(block: bytes, columns: int) -> numpy.ndarray | None:
    """Parses whole lines to a flat array; returns None unless each has `columns` finite numbers."""
    if block.translate(None, ALLOWED):
        return None
    text = numpy.frombuffer(block, numpy.uint8)
    points = numpy.flatnonzero(text == POINT)  # numbers like .5 or 1. are not allowed
    beside = text[numpy.concatenate([points - 1, points + 1])]
    if ((beside < ZERO) | (beside > NINE)).any():
        return None
    ends = text[(text == COMMA) | (text == END)]
    if len(ends) % columns:
        return None
    ends = ends.reshape(-1, columns)
    if (ends[:, :-1] != COMMA).any() or (ends[:, -1] != END).any():
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # numpy warns if a cell is no number
        try:
            found = numpy.fromstring(block[:-1].replace(b"\n", b","), sep=",")
        except (DeprecationWarning, ValueError):
            return None
    whole = len(found) == ends.size and numpy.isfinite(found).all()
    return found if whole else None
