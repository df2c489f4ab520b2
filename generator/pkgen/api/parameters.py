"""Values of a model's parameters."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping
from typing import Any

from ..run import named
from ..run.values import Values
from ..system.near import near
from . import arguments
from .arguments import Value, in_words


class Parameters(MutableMapping[str, float]):
    """Values of parameters in SI units, by name (`m1`, `k[2]`). They can be set as texts: "2 [kg]".
    Raises KeyError for an unknown name, UsageError for an invalid value."""

    def __init__(self, model: Any):
        self._model = model
        self._set: dict[str, float] = {}

    def _known(self, name: str) -> tuple[int, Any]:
        known = named.parameters(self._model.compilation)
        if not isinstance(name, str) or name not in known:
            raise KeyError(f"{name}: {near(str(name), [*known], 'parameter')}")
        return known[name]

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
        self._model._forget()

    def __delitem__(self, name: str) -> None:
        """Resets a parameter to its value in the model's file."""
        self._known(name)
        self._set.pop(name, None)
        self._model._forget()

    def __iter__(self) -> Iterator[str]:
        return named.parameters(self._model.compilation).names()

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __repr__(self) -> str:
        return repr(dict(self))
