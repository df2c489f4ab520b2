"""The part of a model's description on proved constants of the motion."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

from ..compiler import Compilation
from ..graph.differentiate import symbols_in
from ..graph.evaluate import evaluate

POINTS = 5  # Number of random states at which the energy is compared with T + V.
CLOSE = 1e-9  # Relative tolerance of the comparison.


def constants(compilation: Compilation) -> Iterator[dict[str, object]]:
    """Yields the proved constants of the motion. `index` numbers the claims, and the momenta. The
    energy h = q' dL/dq' - L has a different `label` if it is not T + V, for example for a bead on a
    hoop that a motor turns."""
    structure, model = compilation.structure, compilation.model
    energy = "" if model.dimensionless else "J"
    if structure.conservative and compilation.equations.has_energy:
        yield {
            "name": "energy",
            "kind": "energy",
            "index": 0,
            "unit": energy,
            "label": "energy" if _is_sum(compilation) else "Jacobi integral, not T + V",
        }
    for k, item in enumerate(model.conserved):
        yield {"name": item.name, "kind": "claim", "index": k, "unit": item.unit}
    names = compilation.equations.momenta_names
    for k, (q, cyclic) in enumerate(zip(names, structure.cyclic, strict=True)):
        if cyclic:
            yield {"name": q.name, "kind": "momentum", "index": k, "unit": q.unit}


def _is_sum(compilation: Compilation) -> bool:
    """Whether the energy h = q' dL/dq' - L equals T + V at random states. Returns True untested if
    families are compiled to loops, or if the model states L without T and V."""
    e = compilation.equations
    if not e.dense or e.kinetic is None or e.potential is None:
        return True
    chance = random.Random(1)
    nodes = [e.energy, e.kinetic, e.potential]
    symbols = symbols_in(e.graph, nodes)
    for _ in range(POINTS):
        values = {symbol: chance.uniform(0.5, 1.5) for symbol in symbols}
        h, t, v = evaluate(e.graph, nodes, values)
        size = abs(t) + abs(v)
        if math.isfinite(h) and math.isfinite(size) and abs(h - t - v) > CLOSE * size:
            return False
    return True
