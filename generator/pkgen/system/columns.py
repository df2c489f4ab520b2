"""Tables as text."""

from collections.abc import Collection, Sequence


def aligned(rows: Sequence[Sequence[str]], right: Collection[int] = ()) -> list[str]:
    """Returns the rows as lines with aligned columns, those in `right` at the right. A row with
    fewer cells than the first does not widen its columns."""
    whole = [row for row in rows if len(row) == len(rows[0])]
    widths = [max(map(len, column)) for column in zip(*whole, strict=True)]
    lines = []
    for row in rows:
        cells = enumerate(zip(row, widths, strict=False))
        shown = (x.rjust(w) if i in right else x.ljust(w) for i, (x, w) in cells)
        lines.append("  ".join(shown).rstrip())
    return lines
