"""Composes a picture from tables of rows: its panels, axes, lines and colours."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy

from ..system.exits import UsageError
from . import drift, spectrum
from .members import bundle, clouds, few_times, joined
from .methods import mark
from .names import label, shown
from .picture import Axis, Image, Line, Panel, Picture
from .style import PALETTE
from .table import COARSE, CONSTANT, Table, base, ends, finite
from .view import View

PANELS = 6  # Most panels of a picture.
FAMILY = 12  # A family with more members than this is drawn as an image, not as lines.
LINES = 14  # Most lines in one panel.
LONG = 18  # If the names at an axis have more characters, the label of the axis is shortened.
# A column whose size, relative to that of the largest column with the same unit, is below this is
# rounding noise.
NOISE = 1e-9
# Two columns do not share an axis if the size of one is this many times that of the other.
APART = 15.0


def picture(view: View, tables: Sequence[Table]) -> Picture:
    """Returns the picture of the tables. Raises UsageError if they lack columns to draw."""
    planes = (table.at_events or (table.several and few_times(table)) for table in tables)
    kind = view.kind or ("varying" if not view.names and any(planes) else "time")
    made = _MAKERS[kind](view, tables)
    title, notes = _title(tables), tuple(note for table in tables for note in table.notes)
    panels = tuple(_by_method(panel, tables) for panel in made.panels)
    return Picture(title, panels, made.shared, made.wide, (*notes, *made.notes))


def _title(tables: Sequence[Table]) -> str:
    """Returns a title with the model, the scene and the method; an item that differs between tables
    is left out."""
    words = []
    for key in ("model", "scene"):
        found = {str(table.told.get(key, "")) for table in tables}
        words += found if len(found) == 1 and found != {""} else []
    methods = {_method(table) for table in tables}
    said = ", ".join(words[:1] + [f"scene {w}" for w in words[1:]]).replace("_", " ")
    if len(methods) == 1 and methods != {""} and said:
        said += f": {methods.pop()}"
    if any(table.told.get("partial") for table in tables):
        said += " (as far as it came)"
    return said.strip()


def _method(table: Table) -> str:
    return str(table.part("report").get("method", ""))


def _by_method(panel: Panel, tables: Sequence[Table]) -> Panel:
    """Gives each line the colour of its table's method, if each table is drawn as one line and all
    tables have different methods."""
    marks = [mark(_method(table))[0] for table in tables]
    if not 1 < len(tables) == len(set(marks)) or not all(map(_method, tables)):
        return panel
    if any(line.colour >= len(tables) for line in panel.lines):
        return panel
    own = [PALETTE.index(colour) for colour in marks]
    return replace(panel, lines=tuple(replace(x, colour=own[x.colour]) for x in panel.lines))


# -- plots over time -------------------------------------------------------------------------------


def _over_time(view: View, tables: Sequence[Table]) -> Picture:
    names = _columns(view, tables) or _chosen(tables)
    one = len(tables) == 1 and not tables[0].several
    groups = _groups(tables[0], names) if one else [[name] for name in names]
    left = sum(len(group) for group in groups[PANELS:])
    notes = (f"{left} more columns: --columns chooses",) if left else ()
    panels = [(_panel if one else _overlaid)(tables, group) for group in groups[:PANELS]]
    if any(panel.image is not None and _coarse(panel.image) for panel in panels):
        notes += ("rows are too far apart in time for these waves: --every with less shows them",)
    return Picture("", tuple(panels), notes=notes + _points(panels, tables))


def _points(panels: Sequence[Panel], tables: Sequence[Table]) -> tuple[str, ...]:
    """Returns a note that rows are drawn as points, if the rows are too far apart in time for lines
    between them."""
    if any(table.several or table.at_events for table in tables):
        return ()
    if all(line.kind == "line" for panel in panels for line in panel.lines):
        return ()
    return ("rows are too far apart in time to be joined: --every with less makes them lines",)


def _columns(view: View, tables: Sequence[Table]) -> list[str]:
    return [name for (one,) in view.names for name in _in_all(view.option, one, tables)]


def _in_all(option: str, name: str, tables: Sequence[Table]) -> list[str]:
    """Returns the columns that a name denotes. Raises UsageError if they differ between tables."""
    found = [table.found(option, name) for table in tables]
    for table, names in zip(tables, found, strict=True):
        if names != found[0]:
            raise UsageError(f"{option} {name}: {table.label} has other columns of it")
    return found[0]


def _chosen(tables: Sequence[Table]) -> list[str]:
    """Returns the columns that all tables have, without the energy unless it is the only one.
    Raises UsageError if there are none."""
    known = [q.name for q in tables[0].quantities]
    common = [n for n in known if all(n in table.names[1:] for table in tables[1:])]
    if not common:
        others = ", ".join(table.label for table in tables)
        why = "they have no column in common"
        why = why if len(tables) > 1 else f"no column beside {tables[0].columns[0].name}"
        raise UsageError(f"{others}: {why}")
    return [n for n in common if n != "energy"] or common


def _groups(table: Table, names: list[str]) -> list[list[str]]:
    """Groups names into panels: a long family, or columns of equal unit and similar size."""
    found: dict[object, list[str]] = {}
    counts = Counter(base(name) for name in names)
    kinds = {n: (table.quantity(n).unit, n.count("'") + ("omega(" in n)) for n in names}
    sizes = {n: _size(table[n]) for n in names}
    largest: dict[tuple[str, int], float] = {}
    for name in names:
        largest[kinds[name]] = max(largest.get(kinds[name], 0.0), sizes[name])
    for name in names:
        if counts[base(name)] > FAMILY:
            found.setdefault(base(name), []).append(name)
            continue
        kind, size = kinds[name], sizes[name]
        if size < NOISE * largest[kind]:  # rounding noise
            size = largest[kind]
        near = (k for k in found if k[:2] == kind and size / APART < k[2] < size * APART)
        found.setdefault(next(near, (*kind, size)), []).append(name)
    parts = []
    for key, group in found.items():
        size = len(group) if isinstance(key, str) else LINES
        parts += [group[k : k + size] for k in range(0, len(group), size)]
    return parts


def _size(x: numpy.ndarray) -> float:
    """Returns max - min of a column; for a constant column, its absolute value."""
    low, high = ends(x)
    return high - low or abs(low) or 1.0


def _panel(tables: Sequence[Table], names: list[str]) -> Panel:
    """Returns a panel with columns of one table."""
    (table,) = tables
    if len(names) > FAMILY and len({base(n) for n in names}) == 1:
        what = shown(base(names[0])).rstrip("′")
        return Panel(table.axis(), Axis(f"index of {what}"), image=_image(table, names))
    lines = [
        Line(shown(n), table.time, table[n], k, joined(table, table[n]))
        for k, n in enumerate(names)
    ]
    y = Axis(_together(table, names), limits=_flat([table[n] for n in names]))
    return Panel(table.axis(), y, tuple(lines), tight=True)


def _flat(columns: list[numpy.ndarray]) -> tuple[float, float] | None:
    """Returns limits of the axis if all columns are constant, so wide that rounding noise looks
    flat; otherwise None."""
    found = [ends(x) for x in columns if len(finite(x))]
    largest = max((abs(x) for pair in found for x in pair), default=0.0)
    if not largest or any(high - low > CONSTANT * largest for low, high in found):
        return None
    low, high = min(low for low, _ in found), max(high for _, high in found)
    return low - 0.05 * largest, high + 0.05 * largest


def _together(table: Table, names: list[str]) -> str:
    """Returns the label of an axis: the names of all columns if they fit, or the names of their
    families if these fit, or only the unit."""
    unit = table.quantity(names[0]).unit
    bases = list(dict.fromkeys(base(name) for name in names))
    parted = len(bases) < len(names) and not any("[" in name for name in names)
    for some in (bases if parted else names, bases):
        if len(", ".join(map(shown, some))) <= LONG:
            return label(", ".join(some), unit)
    return label("", unit).strip()


def _image(table: Table, names: list[str]) -> Image:
    # More columns of pixels would not be visible on a printed page.
    every = -(-len(table.data) // 1200)
    index = numpy.array([float(n[n.rindex("[") + 1 : n.rindex("]")]) for n in names])
    values = numpy.stack([table[name][::every] for name in names])
    quantity = table.quantity(names[0])
    return Image(values, table.time[::every], index, label(base(quantity.name), quantity.unit))


def _coarse(image: Image) -> bool:
    """Whether an image has fewer than eight columns per period, so that stripes may be aliasing."""
    v = image.values
    whole = numpy.sqrt(numpy.nanmean((v - numpy.nanmean(v, axis=1, keepdims=True)) ** 2))
    return bool(numpy.sqrt(numpy.nanmean(numpy.diff(v, axis=1) ** 2)) > COARSE * whole > 0)


def _overlaid(tables: Sequence[Table], names: list[str]) -> Panel:
    """Returns a panel that shows the same column of several tables, or of many members."""
    (name,) = names
    lines: list[Line] = []
    colours = None
    for table in tables:
        found, colours = bundle(table, table.time, table[name], len(lines), len(tables) > 1)
        lines += found
    own = replace(tables[0].axis(name), limits=_flat([table[name] for table in tables]))
    return Panel(tables[0].axis(), own, tuple(lines), colours=colours, tight=True)


# -- plots of two or three columns -----------------------------------------------------------------


def _plane(view: View, tables: Sequence[Table]) -> Picture:
    option = view.option
    pairs = [_pair(option, names, tables) for names in view.names]
    units = {tuple(tables[0].quantity(n).unit for n in names) for names in pairs}
    if len({len(names) for names in pairs}) > 1 or len(units) > 1:
        raise UsageError(f"{option}: what is drawn together has the same units and axes")
    lines: list[Line] = []
    colours = None
    for names in pairs:
        what = ", ".join(map(shown, names)) if len(pairs) > 1 else ""
        for table in tables:
            count, more = len(lines), len(tables) * len(pairs) > 1
            x, y, *z = (table[name] for name in names)
            if table.several and not table.at_events and few_times(table):
                found = clouds(table, x, y, z, count)
            else:
                found, colours = bundle(table, x, y, count, more, z[0] if z else None)
            lines += [_named(line, what, table, len(tables) > 1) for line in found]
    axes = [_common(tables[0], [names[k] for names in pairs]) for k in range(len(pairs[0]))]
    equal = view.kind == "path" and len(set(next(iter(units)))) == 1
    z_axis = axes[2] if len(axes) == 3 else None
    panel = Panel(axes[0], axes[1], tuple(lines), z_axis, equal=equal, colours=colours)
    return Picture("", (panel,), wide=False, notes=_points([panel], tables))


def _named(line: Line, what: str, table: Table, others: bool) -> Line:
    """Returns the line with the names of its columns, `what`, before its own label."""
    own = "" if line.label == table.label and not others else line.label
    return replace(line, label=", ".join(word for word in (what, own) if word))


def _common(table: Table, names: list[str]) -> Axis:
    """Returns an axis that is labelled with several names, such as x1, x2."""
    names = list(dict.fromkeys(names))
    return Axis(label(", ".join(names), table.quantity(names[0]).unit))


def _pair(option: str, names: tuple[str, ...], tables: Sequence[Table]) -> tuple[str, ...]:
    """Returns the columns along the axes of a curve. If a vector is requested and one of its three
    components is always 0, that component is left out."""
    if len(names) > 1:
        found = [_in_all(option, name, tables) for name in names]
        for name, columns in zip(names, found, strict=True):
            if len(columns) > 1:
                raise UsageError(f"{option} {name}: one of {', '.join(columns[:6])}")
        return tuple(columns[0] for columns in found)
    found = _in_all(option, names[0], tables)
    if len(found) == 3:
        moving = [n for n in found if any(numpy.any(table[n]) for table in tables)]
        found = moving if len(moving) == 2 else found
    if not 2 <= len(found) <= 3:
        raise UsageError(f"{option} {names[0]}: two or three names, or that of a vector")
    return tuple(found)


def _varying(tables: Sequence[Table]) -> tuple[str, str]:
    """Returns a coordinate and its rate if both vary, else the first two columns that vary."""
    table = tables[0]
    names = [q.name for q in table.quantities if q.name != "energy"]
    moving = [n for n in names if _varies(table[n])]
    pairs = [(name, f"{name}'") for name in moving if f"{name}'" in moving]
    if pairs:  # prefer a coordinate whose rate changes sign
        turns = (p for p in pairs if numpy.nanmin(table[p[1]]) < 0 < numpy.nanmax(table[p[1]]))
        return next(turns, pairs[0])
    if len(moving) < 2:
        raise UsageError(f"{table.label}: fewer than two columns that vary: no plane to draw")
    return moving[0], moving[1]


def _varies(x: numpy.ndarray) -> bool:
    low, high = ends(x)
    return bool(len(finite(x))) and high - low > 1e-9 * max(1e-300, abs(low), abs(high))


_MAKERS = {
    "time": _over_time,
    "phase": _plane,
    "path": _plane,
    # Points of a Poincaré section, many members at a few times, or a curve.
    "varying": lambda view, tables: _plane(View("phase", (_varying(tables),)), tables),
    "spectrum": lambda view, tables: spectrum.picture(tables, _columns(view, tables)),
    "drift": lambda view, tables: drift.picture(tables, _columns(view, tables)),
}
