"""pkgen itself: models of models/contact, run by Python."""

from __future__ import annotations

import pkgen

from ..cases import ROOT
from ..pkgen_ import BEST, ready  # noqa: F401
from .cases import LESS, OVER, SPEED, TIMES

VERSION = "pkgen"


def _case(name: str, file: str, columns: str, means: str, says: str, params=({},), start=None):
    columns, every = columns.split(), 0.2 if name == "ball" else 1
    file = ROOT / (f"models/contact/{file}.lag" if file else f"bench/lag/world/{name}.lag")

    def prepare(way: str):
        m, times = pkgen.load(file), TIMES[name]
        options = {} if way == "default" else BEST

        def go():
            end, go.seconds = [], 0.0
            for given in params:
                for key, value in given.items():
                    m.params[key] = value
                rows = m.run(times[-1], every=every, record=columns, start=start, **options)
                go.contacts = rows.report["contacts"]
                go.seconds += rows.report["seconds"]
                end += [rows[c][round(t / every)] for t in times for c in columns]
            return end

        return go

    return prepare, [file], means, says


ROW = "x[1] x[2] x[3] x[4] x[5] x[1]' x[2]' x[3]' x[4]' x[5]'"
STOPS, SLOPES = [{"less": LESS}, {"less": -LESS}], [{"over": -OVER}, {"over": OVER}]
SLIDES = {"x'": SPEED}
CASES = {
    "ball": _case("ball", "bouncing_ball", "y y'", "impact", "72 bounces; the time of rest"),
    "cradle": _case("cradle", "newton_cradle", ROW, "contact", "one by one; warns of two at once"),
    "rock": _case("rock", "rocking_block", "theta theta'", "contact", "the time of rest"),
    "box": _case("box", "box_on_incline", "x x'", "contact", "stops; slides on", SLOPES, SLIDES),
    "belt": _case("belt", "stick_slip_belt", "x x'", "friction", "sticks and slips by itself"),
    "graze": _case("graze", "", "x x'", "contact", "both touches found", STOPS),
}
