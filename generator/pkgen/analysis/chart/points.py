"""Methods as the runtime lists them, and measurements of a method at one step or tolerance."""

from __future__ import annotations

from dataclasses import field

from ...record import record

LOST = 1.0  # a run with this relative error or more has failed
AXES = ("seconds", "work")  # measures of cost

EXPLICIT = "explicit Runge–Kutta, fixed step"
EMBEDDED = "explicit Runge–Kutta, adaptive"
SPLITTING = "splitting"
SYMMETRIC = "implicit symmetric, fixed step"
IMPLICIT_ADAPTIVE = "implicit, adaptive"
DISSIPATIVE = "implicit dissipative, fixed step"
FOREIGN, GSL = "GSL", "gsl_"
PEER = "other packages"
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
    PEER,
)


@record
class ChartedMethod:
    """A method. `imaginary` and `real` are its stability limits: the largest |h lambda| of a stable
    step of size h, for an eigenvalue lambda on the imaginary or the negative real axis. They are
    infinite if every step is stable, 0 if no step is, None if unknown. `peer` names the package
    of the method with its version, or is "" for a method of pkgen's runtime."""

    name: str
    order: int
    flags: tuple[str, ...] = ()
    requires: tuple[str, ...] = ()
    imaginary: float | None = None
    real: float | None = None
    peer: str = ""

    @property
    def fixed(self) -> bool:
        return not self.adaptive

    @property
    def adaptive(self) -> bool:
        return "adaptive" in self.flags

    @property
    def dense(self) -> bool:
        return "dense" in self.flags

    @property
    def implicit(self) -> bool:
        return "implicit" in self.flags

    @property
    def setting(self) -> str:
        """Returns the option of `pkgen run` that sets the method's accuracy."""
        return "step" if self.fixed else "rtol"

    @property
    def family(self) -> str:
        if self.peer:
            return PEER
        if self.name.startswith(GSL):
            return FOREIGN
        if "exact" in self.flags:
            return EXACT
        if {"separable", "linear_drag", "affine_rates"} & {*self.requires}:
            return SPLITTING
        if not self.implicit:
            return EXPLICIT if self.fixed else EMBEDDED
        if not self.fixed:
            return IMPLICIT_ADAPTIVE
        return SYMMETRIC if "symmetric" in self.flags else DISSIPATIVE


@record
class Point:
    """A measured run of a method at one setting. If the run failed, `error` and `seconds` are None.
    If `slow` is true, the run was stopped at the time limit, which does not count as a failure.
    Numbers of steps and evaluations are None if another package does not report them."""

    method: str
    setting: float
    status: str
    reason: str
    slow: bool
    t: float
    error: float | None
    seconds: float | None
    steps: int | None
    rejections: int | None
    evaluations: int | None
    jacobians: int | None
    work: int | None  # evaluations; a Jacobian counts as one per number of the state
    took: float  # CPU seconds of the whole measurement
    drifts: dict[str, float] = field(default_factory=dict)
    least: float | None = None  # range of errors over several starts; `error` is their median
    most: float | None = None
    lucky: bool = False  # accurate by chance: runs with slightly finer settings are less accurate

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
        """Whether the run ended early, or with an error of LOST or more."""
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
        """Returns the cost of the run: CPU seconds, evaluations or steps, as `axis` says (one of
        AXES, or "steps")."""
        cost = getattr(self, axis)
        return None if cost is None else float(cost)


@record
class Track:
    """The points of a method, in the order from loose to tight settings."""

    method: ChartedMethod
    points: tuple[Point, ...]

    @property
    def good(self) -> list[Point]:
        return [p for p in self.points if p.good]

    def cost_at(self, error: float, axis: str) -> float | None:
        """Returns the least cost of a point whose error is at most `error`, or None if there is no
        such point."""
        costs = [p.cost(axis) for p in self.good if p.error is not None and p.error <= error]
        return min((c for c in costs if c is not None), default=None)
