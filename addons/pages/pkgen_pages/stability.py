"""The HTML page of a stability map: the picture, the tables, the failed predictions."""

from __future__ import annotations

from pathlib import Path

from pkgen.analysis.stability import text
from pkgen.analysis.stability.map import StabilityMap

from . import page

CLASSES = """<p>With E the method's energy, S the range of v·p over the motion itself (twice the
kinetic energy that comes and goes), and [a, b] the energies of the last quarter of a run:
<b>growing</b>: E rises by more than S and goes on rising, does not come back, or rises by more
than 10<sup>4</sup> S; <b>drifting</b>: it has left where it began by more than a quarter of b − a
(symplectic and symmetric methods: and by a fifth more after four times as long);
<b>exchange</b>: a coordinate swings three times as far as in the motion; <b>another constant is
lost</b>: one that is proved has moved by 1 %; <b>bounded</b>: none of these, and <b>the phase is
lost</b> where it is elsewhere than the motion before its horizon. <b>not converged</b>,
<b>wrong branch</b>, <b>not finite</b>, <b>singular</b> are what the runtime reports;
<b>not judged</b>: the motion itself leaves and does not come back, or ends. A triangle is a
limit measured: 4000 steps from 10<sup>−6</sup> beside the equilibrium go no further than
10<sup>−3</sup> below it.</p>"""


def html(made: StabilityMap, svg: Path) -> str:
    sections = [
        page.picture(svg.read_text(encoding="utf-8")),
        CLASSES,
        page.heading("Misses"),
        page.items(text.sentences(made)),
    ]
    equilibria = text.equilibria(made)
    first = [("Equilibria and their modes", "", equilibria)] if equilibria[1] else []
    for title, more, (heads, rows) in (*first, *text.tables(made)):
        sections += [
            page.heading(title + more),
            page.table(heads, rows, lambda row: "MISSED" in row),
        ]
    remarks = text.remarks(made)
    if remarks:
        sections += [page.heading("Remarks"), page.items(remarks)]
    return page.document(f"{made.compilation.model.name}: where each method fails", sections)
