"""All predictions, in the order of the page."""

from . import (
    beyond,
    chains,
    contact,
    coupled,
    driven,
    ends,
    first_order,
    kepler,
    knots,
    linear,
    located,
    maps,
    maps_drawn,
    modified,
    noise,
    pendulum,
    resonance,
    rounding,
    sampled,
    scaling,
    stiff,
    tops,
    waves,
)
from .prediction import Missing

LISTED = (linear, resonance, kepler, pendulum, coupled, chains, tops, ends)
OWN = (
    modified,
    maps,
    scaling,
    driven,
    beyond,
    located,
    rounding,
    stiff,
    waves,
    maps_drawn,
    sampled,
    knots,
    first_order,
    contact,
    noise,
)

PREDICTIONS = [entry for part in (*LISTED, *OWN) for entry in part.PREDICTIONS]

MISSING: list[Missing] = []
