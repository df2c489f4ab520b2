"""Very long kernels in several functions, since C compilers are superlinear on straight-line code.

A block's values that a later block needs go through a work array `w`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from .program import CHECK, LOAD, STORE, Block, Statement

# A kernel longer than the first is cut into blocks of about the second, in statements.
_LONGEST = 800
_BLOCK = 400
_ARGUMENTS = ("p", "t", "q", "v", "u", "w")
_WORD = re.compile(r"(?<![\w>])[A-Za-z_]\w*")


def blocks(
    statements: list[Statement], loads: Mapping[str, Statement], outputs: Iterable[str]
) -> tuple[tuple[Block, ...], int]:
    """The blocks, each with the loads that it needs, and the length of the work array."""
    if len(statements) <= _LONGEST:
        parts = [statements]
    else:
        parts = [statements[i : i + _BLOCK] for i in range(0, len(statements), _BLOCK)]
    home = {name: k for k, part in enumerate(parts) for s in part for name in s.defines}
    words = [[_WORD.findall(s.text) for s in part] for part in parts]
    slots: dict[str, int] = {}
    for k, part in enumerate(words):
        for name in (w for line in part for w in line):
            if home.get(name, k) < k:
                slots.setdefault(name, len(slots))
    arguments = (*_ARGUMENTS, *outputs)
    return tuple(
        _block(k, part, words[k], loads, home, slots, arguments) for k, part in enumerate(parts)
    ), len(slots)


def _block(
    k: int,
    part: list[Statement],
    words: list[list[str]],
    loads: Mapping[str, Statement],
    home: Mapping[str, int],
    slots: Mapping[str, int],
    arguments: tuple[str, ...],
) -> Block:
    used = {word for line in words for word in line}
    lines = [load for name, load in loads.items() if name in used]
    lines += [
        Statement(LOAD, name, f"w[{slot}]")
        for name, slot in slots.items()
        if name in used and home[name] < k
    ]
    for statement in part:
        lines.append(statement)
        lines += [
            Statement(STORE, f"w[{slots[name]}]", name)
            for name in statement.defines
            if name in slots
        ]
    text = " ".join(x for s in lines for x in (s.text, s.target if s.kind != CHECK else ""))
    seen = set(_WORD.findall(text))
    return Block(tuple(lines), frozenset(a for a in arguments if a in seen))
