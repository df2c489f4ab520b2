"""How the picture of a chart is asked for; apart from what draws it, which imports matplotlib."""

from __future__ import annotations

from ...record import record


@record
class Look:
    """How the picture is asked for: its cost axis, width in millimetres, kinds of files."""

    axis: str = "seconds"
    width: float = 180.0
    formats: tuple[str, ...] = ("svg", "png")
    dark: bool = False

    @property
    def kinds(self) -> tuple[str, ...]:
        """An SVG in any case, which the page has."""
        return tuple(dict.fromkeys(("svg", *self.formats)))
