"""The headers of the runtime in the C of families: a header is pasted if the C uses its names."""

from __future__ import annotations

import re
from functools import cache

from ..render import source_of, unguarded
from .kernels import BLOCK

# Each stands after those that it includes.
_ALL = (
    "members.h",
    *("members_angles.h", "members_rows.h", "members_ends.h", "members_list.h", "ldl.h"),
    *("members_band.h", "members_chain.h", "members_steps.h"),
)


@cache
def _names(header: str) -> frozenset[str]:
    """Returns the macros, structs and functions that a header defines."""
    found = re.findall(
        r"^#define (\w+)|^struct (\w+) \{|^(?:\w+ )+\*?(pk_\w+)\(", source_of(header), re.MULTILINE
    )
    return frozenset(name for names in found for name in names if name)


@cache
def _included(header: str) -> frozenset[str]:
    """Returns a header and those that it includes."""
    inner = re.findall(r"#include <pk/(\w+\.h)>", source_of(header))
    return frozenset({header}).union(*map(_included, inner))


def headers(block: int, text: str) -> list[str]:
    """Returns the texts of the headers that `text` needs; terms are computed for at most `block`
    members at a time."""
    words = {*re.findall(r"\w+", text)}
    needed = frozenset().union(*(_included(x) for x in _ALL if _names(x) & words))
    found = [unguarded(x) for x in _ALL if x in needed]
    return [x.replace(f"PK_BLOCK {BLOCK} ", f"PK_BLOCK {block} ") for x in found]
