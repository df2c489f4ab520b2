"""The effective potential of a model as an expression, a function and a plot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy

from ..analysis.linear.system import System
from ..compiler import Compilation
from ..equations import Equations
from ..middle.analyze import sympy_bridge
from ..middle.analyze.analyze import cyclic_of
from ..middle.derive.effective import NAME, NotReduced, written
from ..run import named
from .errors import UsageError

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike, NDArray

_LONGEST = 100_000  # largest number of operations of an expression written out in full
_POINTS = 400  # of a plot


class EffectivePotential:
    """V_eff: the energy where cyclic coordinates have the momenta of the start, and all other rates
    are 0. `coordinates` are the others, `momenta` the values by name, `energy` that of the start;
    `str` is the expression."""

    def __init__(self, compilation: Compilation, system: System):
        """Raises UsageError."""
        e = compilation.equations
        assert isinstance(e, Equations)
        self._model, self._system = compilation.model, system
        self._cyclic, self._count = cyclic_of(e), len(e.coordinates)
        try:
            self._written = written(e, self._cyclic)
        except NotReduced as why:
            names = ", ".join(e.coordinates[i].name for i in self._cyclic)
            raise UsageError(f"'{NAME}' is not known: {names} stay, for {why}") from None
        self._names = list(named.coordinates(compilation).names())
        left = (k for k in range(len(self._names)) if k not in self._cyclic)
        self.coordinates = tuple(self._names[k] for k in left)
        if not self.coordinates:
            raise UsageError(f"'{NAME}' is of coordinates that are not cyclic, and there are none")
        self._units = dict(zip(self._names, (q.unit for q in e.coordinates), strict=False))
        self._p = system.kernel("free momenta", 0.0, system.begun)[:, self._cyclic]
        self.momenta = {
            e.momenta_names[i].name: float(p) for i, p in zip(self._cyclic, self._p[0], strict=True)
        }
        self.energy = float(system.kernel("energy", 0.0, system.begun)[0, 0])

    def __call__(self, *places: ArrayLike, **by_name: ArrayLike) -> NDArray[Any]:
        """V_eff, of the shape of the places. These are in the order of `coordinates`, or by name;
        coordinates that are not given are those of the start."""
        given = dict(zip(self.coordinates, places, strict=False)) | by_name
        if len(places) > len(self.coordinates) or given.keys() - {*self.coordinates}:
            raise UsageError(f"{NAME} is a function of {', '.join(self.coordinates)}")
        arrays = numpy.broadcast_arrays(0.0, *given.values())
        states = numpy.tile(self._system.begun, (arrays[0].size, 1))
        v = self._system.v(states)
        v[:, : self._count] = 0  # states follow
        for name, places_of in zip(given, arrays[1:], strict=True):
            states[:, self._names.index(name)] = places_of.ravel()
        of, count = self._cyclic, v.shape[1]
        offset = self._system.kernel("free momenta", 0.0, states)[:, of]
        M = self._system.kernel("mass", 0.0, states).reshape(-1, count, count)[:, of][:, :, of]
        M[numpy.linalg.det(M) == 0] = numpy.nan
        v[:, of] = numpy.linalg.solve(M, (self._p - offset)[..., None])[..., 0]
        found = self._system.kernel("energy", 0.0, states)[:, 0]
        return found.reshape(arrays[0].shape)

    def __str__(self) -> str:
        return sympy_bridge.text(*self._written, _LONGEST)

    def __repr__(self) -> str:
        return f"<{NAME} of {', '.join(self.coordinates)}: {self}>"

    def plot(self, name: str, lo: float, hi: float) -> Figure:
        """Draws V_eff over one coordinate, from `lo` to `hi`, and the energy of the start. The
        other coordinates are those of the start. Returns a matplotlib figure."""
        from ..plot import draw
        from ..plot.names import label
        from ..plot.picture import Axis, Line, Panel, Picture

        x = numpy.linspace(lo, hi, _POINTS)
        y = self(**{name: x})
        lines = Line(NAME, x, y), Line("energy", x[[0, -1]], numpy.full(2, self.energy), 1)
        low, high = numpy.nanmin(y), numpy.nanmax(y)
        deep = self.energy - low
        # A wall of any height is cut off.
        high = min(high, low + 3 * deep) if deep > 1e-6 * (high - low) else high
        unit = "" if self._model.dimensionless else "J"
        limits = low - 0.05 * (high - low), high
        axes = Axis(label(name, self._units[name])), Axis(label(NAME, unit), limits=limits)
        return draw.draw(Picture(self._model.name, (Panel(*axes, lines, tight=True),)))
