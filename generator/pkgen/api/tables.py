"""The data of a model's tables."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping
from typing import Any

import numpy

from ..front.data import WrongData, bringing, of_arrays
from ..system.exits import UsageError
from ..system.near import near

Arrays = tuple[numpy.ndarray, ...]


class Tables(MutableMapping[str, Arrays]):
    """The data of tables by name, in SI units: (x, y), or of a grid (x, y, z) with z of shape
    (len(x), len(y)). Arrays in place of a file: `m.tables["road"] = (x, y)`. Raises KeyError for an
    unknown name, UsageError for data that are no table."""

    def __init__(self, model: Any):
        self._model = model
        self._set: dict[str, Arrays] = {}

    def brought(self) -> Any:
        return bringing(self._set)

    def _known(self, name: str) -> Any:
        known = {x.name: x for x in self._model.compilation.model.tables}
        if name not in known:
            raise KeyError(f"{name}: {near(str(name), [*known], 'table')}")
        return known[name]

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
        self._model._compile_anew()

    def __delitem__(self, name: str) -> None:
        """Resets a table to its file."""
        self._known(name)
        self._set.pop(name, None)
        self._model._compile_anew()

    def __iter__(self) -> Iterator[str]:
        return (x.name for x in self._model.compilation.model.tables)

    def __len__(self) -> int:
        return len(self._model.compilation.model.tables)
