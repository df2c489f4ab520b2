"""Ranks the methods of a chart."""

from __future__ import annotations

from collections import Counter

from .chart import Chart
from .points import AXES, FAMILIES, PEER, Track


def front(tracks: list[Track], axis: str) -> list[str]:
    """Returns the methods that are the cheapest for at least one of many error levels, sorted by
    the number of levels at which they are the cheapest."""
    wins: Counter[str] = Counter()
    for k in range(4, 57):
        error = 10 ** (-k / 4)
        costs = [(c, t.method.name) for t in tracks if (c := t.cost_at(error, axis)) is not None]
        if costs:
            wins[min(costs)[1]] += 1
    return [name for name, _ in wins.most_common()]


def strong(chart: Chart) -> list[str]:
    """Returns the methods that are an answer of the chart, then the first methods of front() for
    each measure of cost, then the best method of each family."""
    named = [a.method.name for a in chart.answers if a.method]
    own = [t for t in chart.tracks if t.method.family != PEER]
    fronts = [front(own, axis) for axis in AXES]
    longest = max(map(len, fronts))
    leading = [f[k] for k in range(longest) for f in fronts if k < len(f)]
    families = [front([t for t in own if t.method.family == f], "seconds")[:1] for f in FAMILIES]
    best = [name for found in families for name in found]
    return list(dict.fromkeys([*named, *leading[:4], *best, *leading]))


def drawn(chart: Chart, most: int) -> list[str]:
    """Returns the `most` methods that a picture shows: one of each other package, and the first
    ones of strong()."""
    peers = []
    for beside in chart.beside:
        names = [a.method.name for a in beside.answers if a.method]
        peers += sorted(set(names), key=lambda name: (-names.count(name), name))[:1]
    own = [name for name in strong(chart) if name not in peers]
    return [*own[: max(1, most - len(peers))], *peers][:most]
