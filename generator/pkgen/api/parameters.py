"""Values of a model's parameters, and the data of its tables, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, MutableMapping
from typing import Any, TypeVar

import numpy

from ..front.data import WrongData, bringing, brought, of_arrays
from ..run import named
from ..run.values import Values
from ..system.exits import UsageError
from ..system.near import near
from . import arguments
from .arguments import Value, in_words

Arrays = tuple[numpy.ndarray, ...]
Kept = TypeVar("Kept")


class Given(MutableMapping[str, Kept]):
    """What the user may set by name in place of what the model's file has. Calls `changed` after
    each change."""

    what = ""  # the kind of thing, for messages

    def __init__(self, model: Any, changed: Callable[[], None]):
        self._model, self._changed = model, changed
        self._set: dict[str, Kept] = {}

    def _every(self) -> Any:
        """Returns what the model has, by name."""
        raise NotImplementedError

    def _known(self, name: str) -> Any:
        known = self._every()
        if not isinstance(name, str) or name not in known:
            raise KeyError(f"{name}: {near(str(name), [*known], self.what)}")
        return known[name]

    def __delitem__(self, name: str) -> None:
        """Resets to what the model's file has."""
        self._known(name)
        self._set.pop(name, None)
        self._changed()

    def __iter__(self) -> Iterator[str]:
        return iter(self._every())

    def __len__(self) -> int:
        return sum(1 for _ in self)


class Parameters(Given[float]):
    """Values of parameters in SI units, by name (`m1`, `k[2]`). They can be set as texts: "2 [kg]".
    Raises KeyError for an unknown name, UsageError for an invalid value."""

    what = "parameter"

    def _every(self) -> named.Named:
        return named.parameters(self._model.compilation)

    def __getitem__(self, name: str) -> float:
        index, _ = self._known(name)
        if name in self._set:
            return self._set[name]
        return float(self._model._handle.given()["parameters"][index])

    def __setitem__(self, name: str, value: Value) -> None:
        _, quantity = self._known(name)
        arguments.checked(params={name: value})
        values, said = Values(self._model.compilation), arguments.text(value)
        with in_words():
            self._set[name] = values.value("params", said, quantity.unit, name)
        self._changed()

    def __iter__(self) -> Iterator[str]:
        return self._every().names()

    def __repr__(self) -> str:
        return repr(dict(self))


class Tables(Given[Arrays]):
    """The data of tables by name, in SI units: (x, y), or of a grid (x, y, z) with z of shape
    (len(x), len(y)). Arrays in place of a file: `m.tables["road"] = (x, y)`. Raises KeyError for an
    unknown name, UsageError for data that are no table."""

    what = "table"

    def brought(self) -> Any:
        return bringing({**brought(), **self._set})

    def _every(self) -> dict[str, Any]:
        return {x.name: x for x in self._model.compilation.model.tables}

    def __getitem__(self, name: str) -> Arrays:
        data = self._known(name).data
        knots = tuple(axis.knots for axis in data.axes)
        return *knots, data.knot_values()

    def __setitem__(self, name: str, arrays: Any) -> None:
        table = self._known(name)
        try:
            given = tuple(numpy.array(x, dtype=float) for x in arrays)
            *axes, values = given
            of_arrays(axes, values, table.kind, table.outside, f"tables[{name!r}]")
        except WrongData as wrong:
            raise UsageError(str(wrong)) from None
        except (TypeError, ValueError) as wrong:
            raise UsageError(f"tables[{name!r}]: give arrays of numbers: {wrong}") from None
        if len(axes) != len(table.data.axes):
            raise UsageError(f"tables[{name!r}]: give {len(table.data.axes) + 1} arrays")
        self._set[name] = given
        self._changed()
