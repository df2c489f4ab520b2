"""Hoists expressions of parameters alone: `prepare` computes them into struct NAME_params."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from ...graph.graph import Graph, Kind, Node, Op, Symbol
from ..targets import STORE, Target
from .constants import Constant
from .expressions import PI, Code, variable
from .names import Names
from .rewrite import Workspace, rewrite
from .schedule import Schedule, number_text


def rewritten(targets: Iterable[Target], new: Mapping[Node, Node]) -> list[Target]:
    """Returns the targets with each node replaced by its value in the map `new`."""
    return [replace(t, nodes=tuple(new[node] for node in t.nodes)) for t in targets]


class Hoisting(ABC):
    """The expressions of a C file, and the constants that `prepare` computes for them."""

    def __init__(self, graph: Graph, name: str, libm: bool) -> None:
        self.prefix = name + "_"
        self.libm = libm
        self.work = Workspace(graph)
        self.hoisted: dict[Node, str] = {}  # node -> its member of NAME_params
        self.constants: list[Constant] = []  # models with loops leave it empty
        self.helpers: set[str] = set()
        self.tables: dict[str, str] = {}  # by name of a table: its member of NAME_params
        self._leaves: dict[Node, Code] = {}

    @abstractmethod
    def symbol(self, symbol: Symbol) -> Code:
        """Returns the C text of a symbol other than pi and t."""

    def fixed_leaf(self, node: Node) -> Code | None:
        """Returns the C text of a symbol or number, None for other nodes."""
        if not self.work.is_leaf(node):
            return None
        if node not in self._leaves:
            self._leaves[node] = self._leaf_text(node)
        return self._leaves[node]

    def leaf(self, node: Node) -> Code | None:
        """Returns the C text of a hoisted node, a symbol or a number, None for other nodes."""
        if node in self.hoisted:
            return variable(self.hoisted[node])
        return self.fixed_leaf(node)

    def _leaf_text(self, node: Node) -> Code:
        data = self.work.data[node]
        if self.work.op[node] is Op.NUMBER:
            return number_text(data)
        assert isinstance(data, Symbol)
        if data.kind is Kind.PI:
            return Code(PI)
        return variable("t") if data.kind is Kind.TIME else self.symbol(data)

    def scheduled(
        self, targets: Iterable[Target], names: Names, fixed: bool = False, **how: Any
    ) -> Schedule:
        """Returns the statements of a kernel or block. With `fixed` they do not read constants that
        `prepare` hoists, but compute them."""
        leaf = self.fixed_leaf if fixed else self.leaf
        inline = not (self.libm or fixed)
        how |= {"inline_sincos": inline, "tables": self.tables}
        found = Schedule(self.work, names, self.prefix, leaf, **how)
        found.run(targets)
        self.helpers |= found.helpers
        return found

    @property
    def hoisted_count(self) -> int:
        return len(set(self.hoisted.values()))

    def named(self, nodes: list[Node], found: Mapping[Node, Node]) -> list[str]:
        """Returns the C names of the members of struct NAME_params that store the constants
        `nodes`. `found` maps each of these nodes to the node in the kernels that it replaces."""
        return [f"c_[{k}]" for k in range(len(nodes))]

    def hoist(self, roots: Iterable[Node], names: Names) -> Schedule:
        """Finds the constants to hoist below the roots; returns the code that computes and stores
        them."""
        found = self._to_hoist(roots)
        new = rewrite(self.work, found, gather=False)
        distinct = sorted({new[node] for node in found})
        placed = self.named(distinct, {new[node]: node for node in found})
        places = {node: f"p->{name}" for node, name in zip(distinct, placed, strict=True)}
        targets = [Target(STORE, places[node], (node,)) for node in distinct]
        schedule = self.scheduled(targets, names, True, known_after=frozenset(places.values()))
        self.hoisted = {node: places[new[node]] for node in found}
        return schedule

    def _to_hoist(self, roots: Iterable[Node]) -> list[Node]:
        """Returns the largest subtrees that depend on parameters alone, except single leaves."""
        found: set[Node] = set()
        seen = set(roots)
        stack = list(seen)
        while stack:
            node = stack.pop()
            if self.work.fixed[node] and self.work.negated(node) is None:
                if not self.work.is_leaf(node):
                    found.add(node)
                continue
            for a in self.work.args[node]:
                if a not in seen:
                    seen.add(a)
                    stack.append(a)
        return sorted(found)
