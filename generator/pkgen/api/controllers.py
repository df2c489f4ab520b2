"""Functions in place of sample blocks: `m.run(controllers={"ctrl": f})`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from ctypes import POINTER, c_double
from typing import Any

import numpy

from ..run import named
from ..run.library import SAMPLE
from ..system.exits import UsageError
from ..system.near import near
from .prepare import Prepared

Controller = Callable[[float, Any, Any, dict[str, float]], Mapping[str, float]]


class Controllers:
    """Functions f(t, q, v, u), called at the samples of the blocks that they replace. u has the
    inputs and memory cells by name; the result has new values of those that the block may set.
    Delays stay."""

    def __init__(self, given: Mapping[str, Controller]):
        self.given = given

    def settings(self, prepared: Prepared, errors: list[BaseException]) -> dict[str, Any]:
        """Returns members of pk_run_settings. Exceptions in functions are appended to `errors`.
        Raises UsageError."""
        compilation = prepared.compilation
        blocks = [block.name for block in compilation.model.samples]
        for name in self.given.keys() - {*blocks}:
            raise UsageError(f"controllers[{name!r}]: {near(name, blocks, 'sample block')}")
        place = {name: i for i, name in enumerate(named.inputs(compilation).names())}
        n = named.coordinates(compilation).count
        seen = numpy.zeros(n + named.coordinates(compilation, rates=True).count)
        values = numpy.zeros(len(place))
        # For each input, its place and those of its values in waiting, by block.
        rows = {block: _rows(compilation.model.inputs, block, place) for block in blocks}
        shown = [name for name in place if "." not in name]

        def sample(_context: object, t: float, k: int) -> int:
            call, own = self.given.get(blocks[k]), rows[blocks[k]]
            if call is None:
                return 0
            try:
                u = {name: float(values[own.get(name, [place[name]])[-1]]) for name in shown}
                new = _numbers(blocks[k], call(t, seen[:n].copy(), seen[n:].copy(), u))
                for name in new.keys() - own.keys():
                    what = near(name, list(own), "input of it")
                    raise UsageError(f"controllers[{blocks[k]!r}]: {name!r}: {what}")
                for name, row in own.items():
                    values[row[:-1]] = values[row[1:]]
                    values[row[-1]] = new.get(name, u[name])
            except BaseException as error:  # no exception may pass through C
                errors.append(error)
            return -1 if errors else 1

        pointer = POINTER(c_double)
        return {
            "sample": SAMPLE(sample),
            "seen": seen.ctypes.data_as(pointer),
            "computed": values.ctypes.data_as(pointer),
        }


def _numbers(block: str, given: Any) -> dict[str, float]:
    try:
        return {name: float(value) for name, value in dict(given).items()}
    except (TypeError, ValueError):
        message = f"controllers[{block!r}] returned {given!r:.40}"
        raise UsageError(f"{message}: it returns numbers by name, e.g. {{'u': 0.5}}") from None


def _rows(inputs: Any, block: str, place: Mapping[str, int]) -> dict[str, list[int]]:
    found: dict[str, list[int]] = {}
    for item in inputs:
        if item.by == block:
            found.setdefault(item.name.partition(".")[0], []).append(place[item.name])
    return found
