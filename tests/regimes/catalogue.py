"""All predictions, in the order of the page."""

from __future__ import annotations

from . import (
    beyond,
    chains,
    coupled,
    driven,
    ends,
    kepler,
    linear,
    maps,
    modified,
    pendulum,
    resonance,
    scaling,
    tops,
)
from .prediction import Missing

LISTED = (linear, resonance, kepler, pendulum, coupled, chains, tops, ends)
OWN = (modified, maps, scaling, driven, beyond)

PREDICTIONS = [entry for part in (*LISTED, *OWN) for entry in part.PREDICTIONS]

MISSING: list[Missing] = []
