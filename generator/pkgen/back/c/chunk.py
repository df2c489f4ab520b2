"""Splits long kernels into functions, since compile time grows faster than their length.

A function passes values to later ones through a work array `w`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ..targets import LOAD, STORE
from .expressions import base, variable
from .program import Block, Statement

# A kernel of more than _LONGEST statements is cut into blocks of _BLOCK. For the kernels of the
# mass matrix and the force of pendulums of 50 and 100 links, gcc takes 0.35 of the time of an uncut
# kernel with blocks of 100 statements, and 0.6 of the time that blocks of 400 take. All run equally
# fast. Blocks of 50 gain little more. If values that are no longer needed were overwritten, `w`
# would be half as long for arms of 20 and 100 joints, but the code would not be faster.
_LONGEST = 800
_BLOCK = 100
ARGUMENTS = ("p", "t", "q", "v", "momenta", "u", "a", "w")


def blocks(
    statements: list[Statement], loads: Mapping[str, Statement], outputs: Iterable[str]
) -> tuple[tuple[Block, ...], int]:
    """Returns the blocks of a kernel's statements, and the length of the work array `w`. Each block
    begins with the loads of the arguments and elements of `w` that it uses."""
    if len(statements) <= _LONGEST:
        parts = [statements]
    else:
        parts = [statements[i : i + _BLOCK] for i in range(0, len(statements), _BLOCK)]
    words = [{name for s in part for name in s.names} for part in parts]
    home: dict[str, int] = {}
    slots: dict[str, int] = {}
    if len(parts) > 1:
        home = {name: k for k, part in enumerate(parts) for s in part for name in s.defines}
        for k, part in enumerate(parts):
            for name in (read for s in part for read in s.reads):
                if home.get(name, k) < k:
                    slots.setdefault(name, len(slots))
    arguments = frozenset((*ARGUMENTS, *outputs))
    places = {name: k for k, name in enumerate(loads)}

    def made(k: int) -> Block:
        needed = [loads[name] for name in sorted(words[k] & places.keys(), key=places.__getitem__)]
        handed = (name for name in words[k] & slots.keys() if home[name] < k)
        for name in sorted(handed, key=slots.__getitem__):
            needed.append(Statement.of(LOAD, name, variable(f"w[{slots[name]}]")))
        return _block(parts[k], needed, words[k], slots, arguments)

    return tuple(map(made, range(len(parts)))), len(slots)


def _block(
    part: list[Statement],
    lines: list[Statement],
    words: set[str],
    slots: Mapping[str, int],
    arguments: frozenset[str],
) -> Block:
    """Returns a block: the loads `lines`, the statements of `part`, and stores to `w` of the values
    that later blocks use."""
    loaded = {base(read) for line in lines for read in line.reads}
    if not slots:  # A single block needs no work array.
        return Block((*lines, *part), arguments & (words | loaded))
    for statement in part:
        lines.append(statement)
        handed_on = [name for name in statement.defines if name in slots]
        lines += [Statement.of(STORE, f"w[{slots[name]}]", variable(name)) for name in handed_on]
        loaded |= {"w"} if handed_on else set()
    return Block(tuple(lines), arguments & (words | loaded))
