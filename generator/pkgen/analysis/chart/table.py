"""Writes the points of a chart as CSV and as JSON, a row for each point."""

from __future__ import annotations

import csv
import io

from .points import ChartedMethod, Point, Track

OF_POINT = [
    "outcome",
    "status",
    "error",
    "least",
    "most",
    "lucky",
    "seconds",
    "evaluations",
    "jacobians",
    "work",
    "steps",
    "rejections",
    "t",
]
COLUMNS = ("method", "family", "peer", "order", "step", "rtol", *OF_POINT)


def record(method: ChartedMethod, point: Point) -> dict[str, object]:
    """Returns a point as {column: value}; a missing value is None."""
    return {
        "method": method.name,
        "family": method.family,
        "peer": method.peer,
        "order": method.order,
        "step": point.setting if method.fixed else None,
        "rtol": None if method.fixed else point.setting,
        **{name: getattr(point, name) for name in OF_POINT},
        **{f"drift({name})": value for name, value in point.drifts.items()},
        "reason": point.reason,
    }


def invariants(tracks: list[Track]) -> list[str]:
    """Returns the names of the constants of motion, in the order of reports."""
    longest = max((p.drifts for t in tracks for p in t.points), key=len, default={})
    return list(longest)


def rows(tracks: list[Track]) -> list[dict[str, object]]:
    return [record(track.method, point) for track in tracks for point in track.points]


def as_csv(tracks: list[Track]) -> str:
    columns = [*COLUMNS, *(f"drift({name})" for name in invariants(tracks)), "reason"]
    file = io.StringIO()
    writer = csv.DictWriter(file, columns, lineterminator="\n")
    writer.writeheader()
    for row in rows(tracks):
        writer.writerow(row | {"lucky": str(row["lucky"]).lower()})
    return file.getvalue()
