"""heyoka: adaptive Taylor methods, compiled by LLVM for this machine.

At its best here: the equations in closed form (its own `lagrangian()` gives longer ones, 1.3 to 1.6
times slower); neither high_accuracy nor compact_mode, both slower at these sizes. Parameters are
compiled in as numbers, or are run-time ones (its `par`), as those of all others in C are: it takes
part both ways. An integrator is compiled for each tolerance, since its order follows from it; that
time is not counted.
"""

from __future__ import annotations

import importlib.metadata
import time
from functools import partial

import sympy as sp

from ..builds import Build, Unavailable
from ..contender import COARSE_TOLERANCES, Callback, Contender
from ..models import Model, equations


def system(model: Model, compiled_in: bool) -> list:
    """The equations as heyoka takes them: (variable, expression), q first."""
    import heyoka

    if compiled_in:
        numbers = dict(zip(model.parameters, map(sp.Float, model.values), strict=True))
        given = {}
    else:
        numbers = {}
        given = {p: heyoka.par[i] for i, p in enumerate(model.parameters)}
    found = [
        (heyoka.expression(str(q)), heyoka.expression(str(v)))
        for q, v in zip(model.q, model.v, strict=True)
    ]
    for v, a in zip(model.v, equations(model.name).acceleration, strict=True):
        right = heyoka.from_sympy(sp.sympify(a).subs(numbers), given)
        found.append((heyoka.expression(str(v)), right))
    return found


def _open(compiled_in: bool, model: Model, _: tuple[Build, ...]) -> list[Callback]:
    try:
        import heyoka
    except ImportError:
        raise Unavailable("heyoka is not installed") from None
    compiled = {}

    def integrate(setting, y0, t_end):
        if setting not in compiled:
            pars = {} if compiled_in else {"pars": list(model.values)}
            compiled[setting] = heyoka.taylor_adaptive(
                system(model, compiled_in), list(y0), tol=setting, **pars
            )
        integrator = compiled[setting]
        integrator.time = 0.0
        integrator.state[:] = y0
        begin = time.perf_counter()
        integrator.propagate_until(t_end)
        return time.perf_counter() - begin, integrator.state

    version = importlib.metadata.version("heyoka")
    return [Callback(integrate, f"heyoka {version}, its LLVM for this CPU, default mode")]


def contenders() -> list[Contender]:
    ladder = (*COARSE_TOLERANCES, 1e-15)
    return [
        Contender("heyoka", "C", False, partial(_open, True), ladder=ladder),
        Contender("heyoka (par)", "C", False, partial(_open, False), ladder=ladder),
    ]
