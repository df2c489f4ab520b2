"""The statements of a kernel, which store, check or return computed values, and its outputs."""

from __future__ import annotations

from ..graph.graph import Node
from ..record import record

# Kinds of statements. In their C code, TARGET is the variable and TEXT the value.
LOCAL = "local"  # const pk_real TARGET = TEXT;
TRIG = "trig"  # declares the sine and cosine of one or two angles; NULL: not used
LOAD = "load"  # const pk_real TARGET = TEXT; TEXT is an argument, like q[0]
STORE = "store"  # TARGET = TEXT;
ADD = "add"  # TARGET += TEXT;
FILL = "fill"  # for all k < TEXT: TARGET[k] = 0;
MIRROR = "mirror"  # copies the upper triangle of TARGET, with TEXT rows, to the lower one
CHECK = "check"  # if (!(TEXT)) return TARGET;
RETURN = "return"  # return TEXT;


@record
class Target:
    """A statement of a kernel. Its value is stored in the C variable `where` and copied to `also`.

    The value is `template`, filled with the texts of `nodes`. `operations` are the operators that
    the template itself contains.
    """

    kind: str
    where: str
    nodes: tuple[Node, ...]
    template: str = "{0}"
    also: tuple[str, ...] = ()
    operations: tuple[str, ...] = ()


@record
class Output:
    """An array that a kernel writes; a matrix is stored row by row."""

    name: str
    rows: int
    columns: int  # 1 for vectors

    @property
    def length(self) -> int:
        return self.rows * self.columns
