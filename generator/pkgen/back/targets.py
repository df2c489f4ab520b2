"""What a kernel does with the values that it computes: the kinds of its statements, its outputs."""

from __future__ import annotations

from ..graph.graph import Node
from ..record import record

# The kinds of a statement.
LOCAL = "local"  # const pk_real TARGET = TEXT;
TRIG = "trig"  # sine and cosine of one value or two into the targets; NULL: not needed
LOAD = "load"  # the same, of an argument: const pk_real theta1 = q[0];
STORE = "store"  # TARGET = TEXT;
ADD = "add"  # TARGET += TEXT;
FILL = "fill"  # for all k < TEXT: TARGET[k] = 0;
MIRROR = "mirror"  # of a symmetric TARGET with TEXT rows, the lower triangle from the upper one
CHECK = "check"  # if (!(TEXT)) return TARGET;
RETURN = "return"  # return TEXT;


@record
class Target:
    """A node whose value goes somewhere; `also` are further places that get a copy.

    The template is completed by the values of `nodes`; `operations` are its own.
    """

    kind: str
    where: str
    nodes: tuple[Node, ...]
    template: str = "{0}"
    also: tuple[str, ...] = ()
    operations: tuple[str, ...] = ()


@record
class Output:
    """An array that a kernel writes; `shape` is its dimensions, each with its C constant."""

    name: str
    rows: int
    columns: int  # 1 for a vector

    @property
    def length(self) -> int:
        return self.rows * self.columns
