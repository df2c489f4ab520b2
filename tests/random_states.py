"""Random states of models with bodies."""

import random

import numpy as np

from pkgen.graph.graph import Kind, Symbol


def state_of(model, draw: random.Random) -> tuple[dict, dict, dict]:
    """Values by symbol; values and rates by name, rotations as wholes."""
    symbols, values, rates = {Symbol(Kind.TIME, 0): 0.4}, {}, {}
    for i, c in enumerate(model.coordinates):
        rate = draw.uniform(-2, 2)
        symbols[Symbol(Kind.RATE, i)] = rate
        symbols[Symbol(Kind.COORDINATE, i)] = values[c.name] = draw.uniform(-2, 2)
        rates[c.name] = rate
    numbers = [s.name for s in model.states]
    for r in model.rotations:
        q = np.array([draw.gauss(0, 1) for _ in range(4)])
        values[r.name] = q / np.linalg.norm(q)
        rates[r.name] = np.array([rates[turn] for turn in r.turns])
        for number, x in zip(r.quaternion, values[r.name], strict=True):
            symbols[Symbol(Kind.STATE, numbers.index(number))] = x
    return symbols, values, rates
