"""heyoka: adaptive Taylor methods, compiled by LLVM for this machine.

At its best here: the equations in closed form (its own `lagrangian()` gives longer ones, 1.3 to 1.6
times slower), parameters compiled in as numbers, which pkgen's are not; neither high_accuracy nor
compact_mode, both slower at these sizes. An integrator is compiled for each tolerance, since its
order follows from it; that time is not counted.
"""

from __future__ import annotations

import importlib.metadata
import time

import sympy as sp

from ..contender import COARSE_TOLERANCES, Callback, Contender, Unavailable
from ..models import Model, equations


def system(model: Model) -> list:
    """The equations as heyoka takes them: (variable, expression), q first."""
    import heyoka

    numbers = dict(zip(model.parameters, map(sp.Float, model.values), strict=True))
    found = [
        (heyoka.expression(str(q)), heyoka.expression(str(v)))
        for q, v in zip(model.q, model.v, strict=True)
    ]
    for v, a in zip(model.v, equations(model.name).acceleration, strict=True):
        found.append((heyoka.expression(str(v)), heyoka.from_sympy(sp.nsimplify(a).subs(numbers))))
    return found


def _open(model: Model) -> list[Callback]:
    try:
        import heyoka
    except ImportError:
        raise Unavailable("heyoka is not installed") from None
    compiled = {}

    def integrate(setting, y0, t_end):
        if setting not in compiled:
            compiled[setting] = heyoka.taylor_adaptive(system(model), list(y0), tol=setting)
        integrator = compiled[setting]
        integrator.time = 0.0
        integrator.state[:] = y0
        integrator.reset_cooldowns() if integrator.with_events else None
        begin = time.perf_counter()
        integrator.propagate_until(t_end)
        return time.perf_counter() - begin, integrator.state

    version = importlib.metadata.version("heyoka")
    return [Callback(integrate, f"heyoka {version}, its LLVM for this CPU, default mode")]


def contenders() -> list[Contender]:
    return [Contender("heyoka", "C", False, _open, ladder=(*COARSE_TOLERANCES, 1e-15))]
