"""Methods as the driver lists them, and what one of them came to at one step or tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

LOST = 1.0  # an error as large as the motion itself

EXPLICIT = "explicit Runge–Kutta, fixed step"
EMBEDDED = "explicit Runge–Kutta, adaptive"
SPLITTING = "splitting"
SYMMETRIC = "implicit symmetric, fixed step"
IMPLICIT_ADAPTIVE = "implicit, adaptive"
DISSIPATIVE = "implicit dissipative, fixed step"
FOREIGN = "GSL"
EXACT = "exact"
FAMILIES = (
    SPLITTING,
    EXPLICIT,
    SYMMETRIC,
    EMBEDDED,
    IMPLICIT_ADAPTIVE,
    DISSIPATIVE,
    FOREIGN,
    EXACT,
)


@dataclass(frozen=True)
class Method:
    """`imaginary` and `real`: how far the method is stable on these axes (of h times the
    eigenvalue); infinite where there is no end, 0 where there is no beginning, None: not known."""

    name: str
    order: int
    flags: tuple[str, ...] = ()
    requires: tuple[str, ...] = ()
    imaginary: float | None = None
    real: float | None = None

    @property
    def fixed(self) -> bool:
        return "adaptive" not in self.flags

    @property
    def setting(self) -> str:
        """What a point of it is a choice of: the option of `pkgen run`."""
        return "step" if self.fixed else "rtol"

    @property
    def family(self) -> str:
        if self.name.startswith("gsl_"):
            return FOREIGN
        if "exact" in self.flags:
            return EXACT
        if "separable" in self.requires:
            return SPLITTING
        if "implicit" not in self.flags:
            return EXPLICIT if self.fixed else EMBEDDED
        if not self.fixed:
            return IMPLICIT_ADAPTIVE
        return SYMMETRIC if "symmetric" in self.flags else DISSIPATIVE


@dataclass(frozen=True)
class Point:
    """`error` and `seconds` are None where the integration did not arrive. `slow`: it was given
    up, which is no failure of the method."""

    method: str
    setting: float
    status: str
    reason: str
    slow: bool
    t: float
    error: float | None
    seconds: float | None
    steps: int
    rejections: int
    evaluations: int
    jacobians: int
    work: int  # evaluations, each Jacobian as many as differences of its columns would take
    took: float  # to measure, in seconds of the processor
    drifts: dict[str, float] = field(default_factory=dict)

    @property
    def arrived(self) -> bool:
        return self.status == "PK_DONE" and not self.slow

    @property
    def refused(self) -> bool:
        return self.status == "PK_REFUSED"

    @property
    def good(self) -> bool:
        return self.arrived and self.error is not None and self.error < LOST

    @property
    def failed(self) -> bool:
        """It ended early, or somewhere else altogether."""
        return not self.good and not self.slow and not self.refused

    @property
    def outcome(self) -> str:
        if self.refused:
            return "refused"
        if self.slow:
            return "given up"
        if not self.arrived:
            return "failed"
        return "done" if self.good else "lost"

    def cost(self, axis: str) -> float | None:
        """`axis` is seconds or work."""
        return self.seconds if axis == "seconds" else float(self.work)


@dataclass(frozen=True)
class Track:
    """A method's points, from loose to tight."""

    method: Method
    points: tuple[Point, ...]

    @property
    def good(self) -> list[Point]:
        return [p for p in self.points if p.good]

    def without_luck(self) -> list[tuple[float, Point]]:
        """Each good point with its error, counted as no smaller than those of all tighter
        settings: a loose one may be lucky."""
        worst, found = 0.0, []
        for point in reversed(self.good):
            worst = max(worst, point.error or 0.0)
            found.append((worst, point))
        return found[::-1]

    def setting_for(self, error: float) -> float | None:
        """The loosest setting that promises the error, log setting linear in log error between
        points; None where none reaches it. A setting looser than any tried is not promised."""
        curve = [(e, p.setting) for e, p in self.without_luck()]
        reached = next((i for i, (e, _) in enumerate(curve) if e <= error), None)
        if reached is None:
            return None
        tight_error, tight = curve[reached]
        if reached == 0 or not tight_error > 0:
            return tight
        loose_error, loose = curve[reached - 1]
        share = math.log(loose_error / error) / math.log(loose_error / tight_error)
        return loose * (tight / loose) ** share

    def cost_at(self, error: float, axis: str) -> float | None:
        """The cost that goes with setting_for()."""
        setting = self.setting_for(error)
        if setting is None:
            return None
        curve = self.good
        below = next((p for p in curve if p.setting <= setting), curve[-1])
        above = next((p for p in reversed(curve) if p.setting >= setting), curve[0])
        low, high = below.cost(axis), above.cost(axis)
        if not low or not high:
            return low or high
        if not above.setting > below.setting:
            return low
        share = math.log(above.setting / setting) / math.log(above.setting / below.setting)
        return high * (low / high) ** share
