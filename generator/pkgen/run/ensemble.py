"""The members of an ensemble: what differs from one to the next, and what can."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from itertools import chain
from typing import TYPE_CHECKING

from ..compiler import Compilation
from ..equations import Quantity
from ..record import record
from . import named

if TYPE_CHECKING:
    import array

    import numpy


@record
class Column:
    """What a column sets: the driver's word for its kind, the index there, its SI unit; `member`
    is of a family of parameters that C has as such."""

    name: str
    kind: str
    index: int
    unit: str
    member: int = 0


@record
class Ensemble:
    """Members of a file or of a scene's swarm, all values in SI."""

    path: str
    columns: tuple[Column, ...]
    lines: Sequence[int]  # where each member stands in the file, or its number in the swarm
    values: array.array | numpy.ndarray = field(repr=False)  # of doubles, member by member
    counted: str = ""  # the variable of a swarm

    @property
    def member(self) -> Quantity:
        """The column that says which member a row is of."""
        if self.counted:
            return Quantity(self.counted, "", "member of the swarm")
        return Quantity("member", "", "row of the ensemble's file, from 1")

    @property
    def title(self) -> str:
        """What its members are from, for the file beside the rows."""
        return f"swarm {self.counted}" if self.counted else os.path.basename(self.path)

    def placed(self, messages: str) -> str:
        """Messages of the run, with the line of the file that a member stands on, or with its
        number in the swarm."""
        if self.counted:
            return re.sub(r"\bmember (-?\d+)", rf"{self.counted} = \1", messages)

        def place(found: re.Match[str]) -> str:
            return f"{self.path}:{self.lines[int(found[1]) - 1]}: "

        return re.sub(r"^run: member (\d+): ", place, messages, flags=re.M)

    def named(self, member: int) -> str:
        """A member, by its number."""
        return f"{self.counted} = {member}" if self.counted else f"member {member}"


class Settable(Mapping[str, Column]):
    """What may differ from member to member, by name; families are not written out."""

    def __init__(self, compilation: Compilation):
        self._kinds = {
            "param": named.parameters(compilation),
            "input": named.inputs(compilation),
            "q": named.coordinates(compilation),
            "v": named.coordinates(compilation, rates=True),
        }
        self._looped = compilation.looped
        starts = compilation.report.starts  # now parameters, of which momenta follow
        self._starts = {name + "'" * order: x for (name, order), x in starts.items()}

    def __getitem__(self, name: str) -> Column:
        of = self._starts.get(name, name)
        for kind, known in self._kinds.items():
            if of in known:
                flat, quantity = known[of]
                member = 0
                if kind == "param" and self._looped:
                    flat, member = known.place(flat)
                return Column(name, kind, flat, quantity.unit, member)
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return chain(*self._kinds.values(), self._starts)

    def __len__(self) -> int:
        return sum(known.count for known in self._kinds.values()) + len(self._starts)
