"""Lengths of families of quantities: the option --size, and limits for unrolled code."""

from __future__ import annotations

import argparse
from collections.abc import Iterable

from .. import limits
from ..system.exits import UsageError

UNROLL = 16  # number of coordinates up to which straight-line code is faster than loops
UNROLL_MEMBERS = 64  # limit for ensembles, whose straight-line code runs in SIMD lanes


def unroll(options: argparse.Namespace, several: bool = False) -> int | None:
    """Returns the number of coordinates up to which families are unrolled; None if all are."""
    usual = UNROLL_MEMBERS if several else UNROLL
    return {"all": None, "none": 0}.get(getattr(options, "unroll", None), usual)


def given(assignments: Iterable[str]) -> dict[str, int]:
    """Returns lengths by name from the values of --size, such as "N=64". Raises UsageError."""
    found = {}
    for text in assignments:
        name, equal, value = text.partition("=")
        digits = value.strip()
        if not (equal and digits.isascii() and digits.isdecimal()):
            raise UsageError(f"--size {text}: give a name and a whole number, e.g. --size N=64")
        if not digits.strip("0"):
            raise UsageError(f"--size {text}: a size is at least 1")
        if name.strip() in found:
            raise UsageError(f"--size {text}: it is given twice")
        if len(digits.lstrip("0")) > 10 or int(digits) > limits.FAMILY:
            raise UsageError(f"--size {text}: the limit is {limits.FAMILY:,}")
        found[name.strip()] = int(digits)
    return found
