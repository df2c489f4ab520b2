"""The members of an ensemble, and the quantities that may differ between them."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from itertools import chain
from typing import TYPE_CHECKING

from ..compiler import Compilation
from ..equations import Quantity
from ..middle.quantities import block_of
from ..record import record
from . import named

if TYPE_CHECKING:
    import array

    import numpy


@record
class Column:
    """The quantity of a column: its kind (as the runtime names it), its index, its SI unit.
    `member` is the 0-based member in a family of parameters that is kept as a loop."""

    name: str
    kind: str
    index: int
    unit: str
    member: int = 0


@record
class Ensemble:
    """The members of an ensemble: the trajectories that differ in the quantities of `columns`. They
    come from a file or from the swarm of a scene. All values are in SI units."""

    path: str
    columns: tuple[Column, ...]
    lines: Sequence[int]  # line of each member in the file, or number in the swarm
    values: array.array | numpy.ndarray = field(repr=False)  # doubles, member by member
    counted: str = ""  # counting variable of a swarm; "" for a file

    @property
    def member(self) -> Quantity:
        """Returns the quantity of the column in which every row has the number of its member."""
        if self.counted:
            return Quantity(self.counted, "", "member of the swarm")
        return Quantity("member", "", "row of the ensemble's file, from 1")

    @property
    def title(self) -> str:
        """Returns the origin of the members, as the sidecar file names it."""
        return f"swarm {self.counted}" if self.counted else os.path.basename(self.path)

    def placed(self, messages: str) -> str:
        """Returns `messages` of a run, rewritten. The runtime counts members; here a member is
        named by its line in the file, or by its number in the swarm."""
        if self.counted:
            return re.sub(r"\bmember (-?\d+)", rf"{self.counted} = \1", messages)

        def place(found: re.Match[str]) -> str:
            return f"{self.path}:{self.lines[int(found[1]) - 1]}: "

        return re.sub(r"^run: member (\d+): ", place, messages, flags=re.M)

    def named(self, member: int) -> str:
        """Returns the text by which messages name a member."""
        return f"{self.counted} = {member}" if self.counted else f"member {member}"


class Settable(Mapping[str, Column]):
    """The quantities, by name, that may differ between members; families are not listed in full."""

    def __init__(self, compilation: Compilation):
        self._kinds = {
            "param": named.parameters(compilation),
            "input": named.inputs(compilation),
            "q": named.coordinates(compilation),
            "v": named.coordinates(compilation, rates=True),
        }
        self._of = compilation
        starts = compilation.report.starts  # initial values that are parameters in C
        self._starts = {name + "'" * order: x for (name, order), x in starts.items()}

    def __getitem__(self, name: str) -> Column:
        of = self._starts.get(name, name)
        for kind, known in self._kinds.items():
            if of in known and not (kind == "input" and block_of(self._of.model, of)):
                flat, quantity = known[of]
                if kind == "q":
                    named.refuse_place(self._of, name)
                member = 0
                if kind == "param":
                    flat, member = known.place(flat)
                return Column(name, kind, flat, quantity.unit, member)
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return chain(*self._kinds.values(), self._starts)

    def __len__(self) -> int:
        return sum(known.count for known in self._kinds.values()) + len(self._starts)
