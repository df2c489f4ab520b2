"""Blocks of C statements of models with families: what they compute and what they read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from ....graph.graph import Node
from ....middle.families.indexed_ir import Over, Slot
from ...targets import TRIG, Target
from ..program import Statement, operations_in

INNER, TERMS, FIXED = "inner", "terms", "fixed"


def plus(text: str, shift: int) -> str:
    return f"{text} {'+' if shift > 0 else '-'} {abs(shift)}" if shift else text


@dataclass
class Window:
    """Successive members of a family, to which a C pointer of a term points: for the first index of
    the term, the members at the index of `slot` plus low .. high."""

    slot: Slot
    pointer: str
    low: int
    high: int

    def text(self, shift: int) -> str:
        """Returns the C expression of the member with the index of `slot` plus `shift`."""
        return f"{self.pointer}[{plus('k', shift - self.low)}]"


@dataclass
class Block:
    """Straight-line code: the expressions to store (`targets`) and the C statements, which Lowering
    adds. `where` is INNER, TERMS or FIXED: how the block reads members of families. In TERMS, the
    block is the body of a loop over the indices `over`; Lowering adds the windows that it reads,
    and the statements before the loop."""

    targets: list[Target]
    where: str
    statements: list[Statement] = field(default_factory=list)
    over: Over = ()
    sequence: bool = False
    windows: list[Window] = field(default_factory=list)
    once: list[Statement] = field(default_factory=list)

    @staticmethod
    def of(kind: str, place: str, nodes: Iterable[Node], where: str) -> Block:
        """Returns a block that stores each node. The C variables are `place`, a format such as
        "r[{}]", filled with the number of the node."""
        targets = [Target(kind, place.format(k), (node,)) for k, node in enumerate(nodes)]
        return Block(targets, where)

    @property
    def pairs(self) -> bool:
        return len(self.over) == 4

    @property
    def operations(self) -> Counter[str]:
        return operations_in(self.statements)

    @property
    def trig(self) -> bool:
        return any(s.kind == TRIG for s in self.statements)

    @property
    def words(self) -> set[str]:
        """Returns the names of all variables and functions in the block."""
        return {name for s in self.statements for name in s.names}

    @property
    def nodes(self) -> list[Node]:
        return [node for target in self.targets for node in target.nodes]

    @property
    def value(self) -> str:
        """Returns the text of a block that consists of one expression."""
        [statement] = self.statements
        return statement.text
