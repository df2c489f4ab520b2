"""Amplitude spectra of columns whose rows are equidistant in time.

They use a Hann window, whose side lobes decay like the third power of frequency: F. J. Harris,
Proc. IEEE 66 (1978) 51. For precise frequencies there is `--diagnose spectrum`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy

from ..system.exits import UsageError
from .names import label, shown
from .picture import Axis, Line, Panel, Picture
from .table import Table

LEAST = 16  # Fewest rows for a spectrum.
DEPTH = 1e-7  # Lower limit of the amplitude axis, relative to the highest peak.
# The frequency axis ends after the last amplitude that is above this fraction of the highest peak.
TAIL = 1e-4


def picture(tables: Sequence[Table], names: list[str]) -> Picture:
    lines = []
    for name in names:
        for table in tables:
            omega, amplitude = amplitudes(table, name)
            words = [shown(name)] if len(names) > 1 else []
            words += [table.label] if len(tables) > 1 else []
            lines.append(Line(", ".join(words), omega, amplitude, len(lines)))
    highest = max(float(line.y.max()) for line in lines)
    if not highest > 0:
        raise UsageError(f"--spectrum {', '.join(names)}: constant: there is no line")
    reach = max(float(line.x[line.y > TAIL * highest].max(initial=0)) for line in lines)
    most = max(float(line.x[-1]) for line in lines)
    first = tables[0]
    units = {first.quantity(name).unit for name in names}
    time = first.columns[first.abscissa].unit
    said = label("angular frequency", f"rad/{time}" if time else "")
    x = Axis(said, limits=(0, min(most, 1.25 * reach)))
    of = f" of {names[0]}" if len(names) == 1 else ""
    said = label(f"amplitude{of}", units.pop() if len(units) == 1 else "")
    limits = (DEPTH * highest, 3 * highest)
    return Picture("", (Panel(x, Axis(said, log=True, limits=limits), tuple(lines), tight=True),))


def amplitudes(table: Table, name: str) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Returns angular frequencies and amplitudes of the first rows that are equidistant and finite.
    Raises UsageError if they are fewer than LEAST."""
    if table.several:
        raise UsageError(f"--spectrum {name}: one motion is needed; {table.label} has many")
    t, x = table.time, table[name]
    steps = numpy.diff(t)
    even = numpy.abs(steps - steps[:1]) <= 1e-6 * numpy.abs(steps[:1])
    count = len(t) if even.all() else int(numpy.argmin(even)) + 1  # the last row may be at an event
    good = numpy.isfinite(x[:count])
    count = count if good.all() else int(numpy.argmin(good))
    if count < LEAST or not steps[0] > 0:
        raise UsageError(
            f"--spectrum {name}: {LEAST} rows at least, equally far apart in time; "
            f"{table.label} has {count}"
        )
    window = numpy.hanning(count)
    # Subtract the mean: leakage of this component would hide low frequencies.
    values = x[:count] - numpy.sum(window * x[:count]) / numpy.sum(window)
    found = numpy.abs(numpy.fft.rfft(window * values)) * 2 / numpy.sum(window)
    return 2 * numpy.pi * numpy.fft.rfftfreq(count, float(steps[0])), found
