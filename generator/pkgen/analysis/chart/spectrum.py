"""Frequencies along a motion, from which stability limits of fixed-step methods follow.

Let a(q, v) be the accelerations. Near a state of the motion, a displacement y = (dq, dv) obeys the
linearised equations y' = J y, with J = [[0, 1], [da/dq, da/dv]]. A method with the step size h is
stable if h times each eigenvalue of J lies in the method's region of stability. The ends
y_imaginary and y_real of this region, on the imaginary and the negative real axis, are known
(`pkgen methods`). J is computed at many times of the motion. Let omega be the largest imaginary
part of its eigenvalues. Let rho be the fastest decay: the largest -(real part) of a real
eigenvalue, in dissipative systems only (in others a negative eigenvalue belongs to a saddle that
the motion passes). Then

    h_limit = min(y_imaginary / omega, y_real / rho).

For a nonlinear motion this limit is only a guide, since the motion is fastest for a part of its
duration. Reference: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.2.
"""

from __future__ import annotations

import math

from ...record import record
from .measure import Program
from .points import ChartedMethod

TIMES = 200
TOLERANCE = 1e-8
SLOWEST = 10.0  # most CPU seconds of the integration
DAMPED = 1e-6  # an eigenvalue with a relative imaginary part below this counts as real


@record
class Spectrum:
    """The largest angular frequency `omega` and the largest decay rate `rho` along the motion up to
    the time `until`, per unit of time. Each is 0 if the motion does not oscillate or decay."""

    omega: float
    rho: float
    until: float

    @property
    def fastest(self) -> float:
        return max(self.omega, self.rho) or 1.0 / self.until

    def limit(self, method: ChartedMethod) -> float | None:
        """Returns the step size at which a fixed-step method becomes unstable; None if no limit is
        known."""
        if not method.fixed:
            return None
        limits = [
            end / rate
            for end, rate in ((method.imaginary, self.omega), (method.real, self.rho))
            if end is not None and math.isfinite(end) and end > 0 and rate > 0
        ]
        return min(limits) if limits else None

    def text(self, time: str) -> str:
        if not self.omega and not self.rho:
            return "nothing oscillates or decays along the motion: no step is beyond a limit"
        turns = self.omega * self.until / (2 * math.pi)
        unit = f" rad/{time}" if time else ""
        said = f"fastest oscillation along the motion {self.omega:.4g}{unit}: {turns:.3g} periods"
        if self.rho > 0:
            said += f"; fastest decay {self.rho:.3g}{f' /{time}' if time else ''}"
        return said


def find(program: Program, method: str, until: float, dissipative: bool) -> Spectrum:
    """Returns the spectrum along a motion, which is integrated by the adaptive `method`."""
    import numpy

    done = program.path(method, TOLERANCE, TIMES, SLOWEST)
    rows, end = done.rows(), 1 + len(program.start["q"])
    t, q, v = rows[:, 0], rows[:, 1:end], rows[:, end:]
    n = v.shape[1]
    omega = rho = 0.0
    for a in done.evaluate("jacobian", t, q, v).reshape(-1, 2, n, n):
        if not numpy.isfinite(a).all():
            continue
        jacobian = numpy.block([[numpy.zeros((n, n)), numpy.eye(n)], [a[0], a[1]]])
        for value in numpy.linalg.eigvals(jacobian):
            if abs(value.imag) > DAMPED * abs(value):
                omega = max(omega, abs(float(value.imag)))
            elif dissipative:
                rho = max(rho, -float(value.real))
    return Spectrum(omega, rho, until)
