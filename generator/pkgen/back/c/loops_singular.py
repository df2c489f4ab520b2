"""The C tables of singularities in models whose families are loops."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import zip_longest

from ...graph.affine import ROW, Affine
from ...indices import indexed
from ...middle.loops.loops import LoopEquations
from .loops import Places


def described(e: LoopEquations, places: Places) -> Iterator[dict[str, str]]:
    """Yields a row of the table for each singularity; pivots of M come first."""
    for g in e.coordinates if e.pivots else ():
        name = f"the pivot of {indexed(g.shown, 'i' if g.is_family else None)}"
        yield _singularity(places, name, "COORDINATES", (g.lo, g.hi) if g.is_family else ())
    for x in e.singularities:
        [over] = [
            *((p.lo, p.hi) for p in x.terms.parts),
            *((p.lo, p.hi, p.first, p.last) for p in x.terms.pairs),
        ] or [()]
        yield _singularity(places, x.name, x.use, over)


def _singularity(places: Places, text: str, use: str, over: tuple[Affine, ...]) -> dict[str, str]:
    found = {"name": text, "kind": f"PK_SINGULARITY_{use}"}
    for key, at in zip_longest(("lo", "hi", "first", "last"), over):
        found[key] = "" if at is None else places.index(at)
        found[f"{key}_text"] = "" if at is None else at.text({ROW: "i"})
    return found
