"""Pictures of a linear model: poles, Bode diagrams, root loci.

Reference: K. J. Astrom, R. M. Murray, Feedback Systems, 2nd edition (2020), ch. 9, 10 and 12.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy
from numpy import linalg

from pkgen.plot.names import shown
from pkgen.plot.picture import Axis, Line, Panel, Picture
from pkgen.plot.style import PALETTE
from pkgen.system.exits import UsageError

from .state_space import Linear, reached

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

KINDS = ("poles", "bode", "root_locus")
_GRID, _BESIDE = 600, numpy.logspace(-5, -1, 30)  # frequencies of a diagram; beside a resonance
_GAINS = 1500  # of a root locus
_CIRCLES = numpy.exp(1j * numpy.linspace(0.05, math.pi, 40))


def picture(linear: Linear, kind: str, pairs: Sequence[tuple[str, str]] = ()) -> Picture:
    """Returns a picture of KINDS. `pairs` are outputs and inputs, by default all. Raises
    UsageError."""
    if kind == "poles":
        return poles(linear)
    pairs = pairs or [(y, u) for y in linear.outputs for u in linear.inputs]
    if not pairs:
        raise UsageError(f"{kind}: the model has no input")
    if len(pairs) > (len(PALETTE) if kind == "bode" else 1):
        outputs, inputs = ", ".join(linear.outputs), ", ".join(linear.inputs)
        raise UsageError(f"{kind}: name an output, of {outputs}, and an input, of {inputs}")
    return bode(linear, pairs) if kind == "bode" else root_locus(linear, *pairs[0])


# -- poles -----------------------------------------------------------------------------------------


def poles(linear: Linear) -> Picture:
    """Returns all poles, the uncontrollable and the unobservable ones."""
    A, B, C, _ = linear
    sets = {"pole": linear.poles, "uncontrollable": _left(A, B), "unobservable": _left(A.T, C.T)}
    lines = [
        Line(f"{len(z)} {name}{'s' * (name == 'pole' != len(z))}", z.real, z.imag, k, "points")
        for k, (name, z) in enumerate(sets.items())
        if z.size
    ]
    return _plane(linear, lines, max(abs(linear.poles), default=1.0))


def _left(A: NDArray[Any], B: NDArray[Any]) -> NDArray[Any]:
    """Returns the eigenvalues of A in the part of the states that B does not reach."""
    basis = reached(A, B)
    rest = linalg.svd(basis)[0][:, basis.shape[1] :] if basis.size else numpy.eye(len(A))
    return linalg.eigvals(rest.T @ A @ rest)


def _plane(linear: Linear, lines: list[Line], reach: float) -> Picture:
    """Returns a picture of the complex plane up to `reach`, in discrete time with the circle in
    which a motion is stable."""
    if linear.period:
        z = numpy.exp(1j * numpy.linspace(0, 2 * math.pi, 200))
        lines, reach = [*lines, Line("", z.real, z.imag, 6)], max(reach, 1.0)
    limits = (-1.15 * reach, 1.15 * reach) if reach else (-1.0, 1.0)
    unit = "" if linear.period else " [1/s]"
    axes = (Axis(f"{part}{unit}", limits=limits) for part in ("real part", "imaginary part"))
    return Picture("", (Panel(*axes, tuple(lines), equal=True),), wide=False)


# -- Bode ------------------------------------------------------------------------------------------


def bode(linear: Linear, pairs: Sequence[tuple[str, str]]) -> Picture:
    """Returns magnitude and phase over the angular frequency."""
    w = frequencies(linear)
    H = linear.frequency_response(w)
    panels: tuple[list[Line], list[Line]] = [], []
    for k, pair in enumerate(pairs):
        h = H[(slice(None), *linear.places(*pair))]
        phase = numpy.full(len(w), numpy.nan)
        good = numpy.isfinite(h) & (h != 0)
        phase[good] = numpy.degrees(numpy.unwrap(numpy.angle(h[good])))
        with numpy.errstate(divide="ignore"):
            both = 20 * numpy.log10(abs(h)), phase
        for lines, y in zip(panels, both, strict=True):
            lines.append(Line(f"{shown(pair[0])}/{shown(pair[1])}", w, y, k))
    x = Axis("angular frequency [rad/s]", log=True)
    named = zip(("magnitude [dB]", "phase [°]"), panels, strict=True)
    made = (Panel(x, Axis(name), tuple(lines), tight=True) for name, lines in named)
    return Picture("", tuple(made))


def frequencies(linear: Linear) -> NDArray[Any]:
    """Returns frequencies from a tenth of the slowest pole to ten times the fastest, closer beside
    each. In discrete time they end at half the sampling rate."""
    corners = abs(linear.poles)
    if linear.period:
        with numpy.errstate(divide="ignore"):
            corners = abs(numpy.log(linear.poles)) / linear.period
    corners = corners[numpy.isfinite(corners) & (corners > 1e-6 * corners.max(initial=0.0))]
    corners = corners if corners.size else numpy.ones(1)
    low, high = math.log10(corners.min()) - 1, math.log10(corners.max()) + 1
    beside = [x * (1 + sign * _BESIDE) for x in corners for sign in (-1, 1)]
    w = numpy.unique(numpy.concatenate([numpy.logspace(low, high, _GRID), *beside]))
    return w[w < math.pi / linear.period] if linear.period else w


# -- the root locus --------------------------------------------------------------------------------


def root_locus(linear: Linear, output: str, input: str, gain: float | None = None) -> Picture:
    """Returns the poles with the feedback u = -k y for k from 0 to `gain`, by default so far that
    they end at the zeros. Raises UsageError."""
    zeros = linear.zeros(output, input)
    i, j = linear.places(output, input)
    ends = numpy.concatenate([linear.poles, zeros])
    reach = abs(ends).max(initial=0.0) or 1.0
    radii = reach * numpy.logspace(-2, 1, 7)
    sizes = abs(linear.response((radii[:, None] * _CIRCLES).ravel())[:, i, j])
    sizes = sizes[(sizes > 0) & numpy.isfinite(sizes)]
    if not sizes.size:
        raise UsageError(f"root_locus: {output} does not depend on {input}")
    low, high = -math.log10(sizes.max()) - 2, -math.log10(sizes.min()) + 2
    gains = numpy.logspace(low, high, _GAINS)
    if gain is not None:
        gains = math.copysign(1, gain) * numpy.logspace(-6, 0, _GAINS) * abs(gain)
    found = branches(linear.closed_poles(output, input, numpy.array([0.0, *gains])))
    lines = [Line("", z.real, z.imag) for z in found.T]
    marks = ("poles", linear.poles), ("zeros", zeros)
    lines += [
        Line(name, z.real, z.imag, k, "points") for k, (name, z) in enumerate(marks, 1) if z.size
    ]
    shown_reach = 1.3 * reach if gain is None else max(reach, abs(found).max())
    return _plane(linear, lines, shown_reach)


def branches(poles: NDArray[Any]) -> NDArray[Any]:
    """Returns rows of poles in such an order that each column is continuous."""
    from scipy.optimize import linear_sum_assignment

    found = poles.copy()
    for k in range(1, len(found)):
        apart = abs(found[k - 1][:, None] - found[k])
        found[k] = found[k][linear_sum_assignment(apart)[1]]
    return found


class LinearModel(Linear):
    """A linear model that can be drawn. Methods return matplotlib figures, and raise UsageError."""

    def bode(self, output: str | None = None, input: str | None = None) -> Figure:
        """Draws magnitude and phase of a transfer function, by default of all."""
        outputs = self.outputs if output is None else (output,)
        inputs = self.inputs if input is None else (input,)
        return _drawn(picture(self, "bode", [(y, u) for y in outputs for u in inputs]))

    def root_locus(self, output: str, input: str, gain: float | None = None) -> Figure:
        """Draws the poles with the feedback u = -k y for k from 0 to `gain`, which may be negative;
        by default so far that they end at the zeros."""
        return _drawn(root_locus(self, output, input, gain))

    def plot_poles(self) -> Figure:
        """Draws the poles, and which of them are uncontrollable or unobservable."""
        return _drawn(poles(self))


def _drawn(made: Picture) -> Figure:
    from pkgen.plot.draw import draw

    return draw(made)
