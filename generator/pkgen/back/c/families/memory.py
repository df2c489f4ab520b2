"""The model's memory: working arrays of kernels, whose lengths depend on the sizes."""

from __future__ import annotations

from ....graph.affine import Affine
from ....middle.families.equations import FamilyEquations
from .bound import Layout
from .places import Places
from .plan import Plan, watches_momenta


def memory_regions(
    e: FamilyEquations, places: Places, plan: Plan, layouts: dict[str, Layout], answered: bool
) -> dict[str, dict[str, str]]:
    """Returns the parts of the model's memory behind families of parameters: their lengths and
    descriptions, in order."""
    index, name = places.index, e.model.name
    found, count = {}, index(e.count)
    if e.carried:
        found["memory"] = {"count": f"{name}_memory_size(p)", "says": "Carried values"}
    if "K" in layouts:
        found["K"] = {
            "count": "(ptrdiff_t)pk_matrix_size(&K)",
            "says": "M, or K = [M J^T; J 0]",
        }
        found["unknowns"] = {"count": "K.all", "says": "Unknowns of K"}
    if e.bound:
        rows = sum((x.group.count for x in e.bound), Affine())
        found["lambda"] = {"count": index(rows), "says": "Multipliers"}
    if answered or e.bound:
        found["accelerated"] = {"count": count, "says": "Accelerations"}
    if "K" in layouts and layouts["K"].spares:
        spares = str(layouts["K"].spares)
        found["spared"] = {"count": spares, "says": "Rows of constraints that have a spare"}
    if watches_momenta(e):
        found["momentum"] = {"count": count, "says": "Momenta that outputs have"}
    if plan.rates:
        found["rated"] = {"count": count, "says": "Rates of states that others use"}
    if any(key.startswith("sum_") for key in plan.totals):
        found["sums"] = {"count": str(len(e.sums)), "says": "Sums that terms have in them"}
    if plan.along:
        length = index(places.n_lets)
        found["lets"] = {"count": length, "says": "Values of each member that outputs need"}
    return found
