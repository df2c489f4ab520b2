"""Each prediction of the catalogue: met, and not met by the worse method or step beside it."""

import math
import os
import re
import shlex
import subprocess
from dataclasses import replace

import pytest

from pkgen.run.build import runtime_methods

from .catalogue import MISSING, PREDICTIONS
from .chains import kink_frequency
from .prediction import Prediction
from .shown import LOOP, MODELS
from .stability_page import (
    HEAD,
    PAGE,
    command_of,
    predicted,
    rows,
    sections,
    text,
    without_method,
    write,
)


def parameters() -> list:
    """Every fourth of those that are not long is quick: neighbours are of one system."""
    return [
        pytest.param(p, id=p.id, marks=[pytest.mark.long] if p.long or k % 4 else [])
        for k, p in enumerate(PREDICTIONS)
    ]


def said_by_the_page(entry: Prediction, measured: float) -> bool:
    """Whether the page's figure is this one: both in the band, or closer than the tolerance."""
    said = float(rows()[entry.id][5])
    if isinstance(entry.predicted, tuple) or entry.missed:
        return entry.met(said) == entry.met(measured)
    return abs(said - measured) <= max(entry.tolerance, 1e-8) * abs(entry.predicted)


@pytest.mark.parametrize("entry", parameters())
def test_prediction(entry: Prediction) -> None:
    if entry.needs:
        pytest.importorskip(entry.needs)
    if entry.command and not os.environ.get("PKGEN_UPDATE"):
        assert command_of(entry.id) == entry.command  # what is run is what the page shows
    measured, worse = entry.measure(), entry.measure_worse()
    write(entry, measured, worse)
    assert entry.met(measured) == (not entry.missed), f"{measured!r}: {entry.missed or 'missed'}"
    assert not entry.met(worse), f"{entry.worse} meets it too: {worse!r}"
    assert said_by_the_page(entry, measured)
    # Nothing at all is no measurement, unless nothing is what was predicted.
    assert measured != 0 or entry.predicted == (0.0, 0.0)


def wrong(entry: Prediction) -> Prediction:
    """By three tolerances."""
    if isinstance(entry.predicted, tuple):
        low, high = entry.predicted
        return replace(entry, predicted=(2 * high - low + 1e-9, 3 * high - 2 * low + 1e-9))
    off = 3 * entry.tolerance * abs(entry.predicted) or 1.0
    return replace(entry, predicted=entry.predicted + off)


def test_a_wrong_prediction_is_missed() -> None:
    known = rows()
    for entry in PREDICTIONS:
        assert entry.missed or not wrong(entry).met(float(known[entry.id][5])), entry.id


def test_the_catalogue_is_large_enough() -> None:
    ids = [p.id for p in PREDICTIONS] + [m.id for m in MISSING]
    assert len(set(ids)) == len(ids)
    own = [p for p in PREDICTIONS if p.own]
    assert len(ids) >= 200 and len(own) >= 10 and sum("limit" in p.says for p in own) <= 3
    assert sum(bool(p.command) for p in PREDICTIONS) > 0.7 * len(ids)


def test_a_shell_reads_a_command_as_it_is_run() -> None:
    commands = [command_of(e.id) for e in PREDICTIONS if e.command]
    bodies = [m[3].replace(f"${m[1]}", "1") if (m := LOOP.fullmatch(c)) else c for c in commands]
    script = "pkgen() { printf '%s\\t' \"$@\"; echo; }\n" + "\n".join(bodies)
    said = subprocess.run(["sh", "-c", script], cwd=MODELS, capture_output=True, text=True)
    read = [line.split("\t")[:-1] for line in said.stdout.splitlines()]
    assert read == [shlex.split(body)[1:] for body in bodies] and not said.stderr


# Methods that are none of the runtime's.
OTHERS = ("without compensated sums", "the same of each step's start", "RK4 without singularities")


def test_what_is_worse_is_a_method_or_says_why_not() -> None:
    names = {m["name"] for m in runtime_methods()}
    for entry in PREDICTIONS:
        first = re.split(r"[,:]| which", entry.worse)[0]
        assert (first in names or entry.worse.startswith(OTHERS)) != bool(entry.no_method), entry.id
    assert 0 < len(without_method()) < len(PREDICTIONS) / 10


@pytest.mark.parametrize("d, n, w", [(1.0, 40, 0.24583955), (1.1, 40, None)])
def test_a_frequency_is_found_without_being_told(d: float, n: int, w: float | None) -> None:
    """The window of the scan is the samples' own, for any lattice: it is never the edge of it."""
    found = kink_frequency(d, n, 100.0)
    other = kink_frequency(d, n, 131.0)
    assert found == pytest.approx(other, rel=5e-3)
    if w:
        assert found == pytest.approx(w, rel=1e-2)
    else:  # the old window ended at 1.2 times the frequency of d = 1
        assert abs(found - 1.2 * 0.24583955) > 5e-3


def same(said: str, computed: str) -> bool:
    try:
        return math.isclose(float(said), float(computed), rel_tol=1e-9)
    except ValueError:  # a band, or a word
        return said == computed


def test_the_page_is_the_catalogues() -> None:
    known = rows()
    assert list(known) == [p.id for section in sections() for p in section]
    assert PAGE.read_text().startswith(HEAD)
    for entry in PREDICTIONS:
        cells = known[entry.id]
        assert re.sub(r" \*\(long, [\d-]+\)\*$", "", cells[1]) == entry.system
        assert cells[2] == entry.says.replace("|", "\\|")
        # Closed forms differ in their last digit with the precision that mpmath was left at.
        assert same(cells[3], predicted(entry)) and cells[7] == entry.worse
        measured, worse = (math.inf if c == "none" else float(c) for c in (cells[5], cells[8]))
        assert cells[9] == ("met" if entry.met(measured) else "**MISSED**")
        assert entry.met(measured) == (not entry.missed) and not entry.met(worse)
    assert PAGE.read_text() == text(known)
