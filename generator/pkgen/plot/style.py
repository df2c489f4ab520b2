"""The style of all pictures: colours, font sizes, widths, and metadata of files.

Most colours are from the palette of M. Okabe and K. Ito, whose colours are distinguishable with any
usual colour vision. The two widths are those of a column and of a page in most journals. Picture
files contain no date, so that they are reproducible.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from ..record import record
from ..system.exits import UsageError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLUE, RED, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
ORANGE, SKY, BLACK, YELLOW = "#E69F00", "#56B4E9", "#000000", "#F0E442"
BROWN = "#7A4A21"
INK, GREY, PALE = "#222222", "#8C8C8C", "#E4E4E4"
# Colours of lines 0, 1, ...; dashes distinguish lines that are printed without colours.
PALETTE = (BLUE, RED, GREEN, PURPLE, ORANGE, SKY, BLACK, BROWN)
DASHES = ("-", (0, (5, 1.5)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)))
SEQUENTIAL, DIVERGING = "cividis", "RdBu_r"

COLUMN, PAGE = 90 / 25.4, 180 / 25.4  # inches
FORMATS = ("svg", "png", "pdf")
# A picture as a file for LaTeX, which sets the text of the picture in the font of the document.
OF_LATEX = "pgf"
DPI = 200
DPI_WITHIN = 144  # Resolution, in dots per inch, of rasterized parts of vector files.
# Viewers without DejaVu Sans use these fonts. Their letters are about as wide, so labels stay in
# place.
FONTS = "'DejaVu Sans', Verdana, sans-serif"
# Settings of matplotlib for all files.
FILES = {
    "svg.hashsalt": "pkgen",
    # Text is stored as text, not as outlines: files are smaller and searchable.
    "svg.fonttype": "none",
    "pdf.fonttype": 42,  # Fonts are embedded as TrueType, which publishers accept.
    "font.family": "DejaVu Sans",
    "hatch.linewidth": 0.4,
}
_INKED = ("axes.edgecolor", "axes.labelcolor", "text.color", "xtick.color", "ytick.color")
LOOK = {
    **FILES,
    **dict.fromkeys(_INKED, INK),
    **dict.fromkeys(("font.size", "axes.labelsize"), 8),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize"), 7),
    **dict.fromkeys(("axes.linewidth", "xtick.major.width", "ytick.major.width"), 0.6),
    **dict.fromkeys(("xtick.major.size", "ytick.major.size"), 3),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right"), False),
    "axes.titlesize": 8.5,
    "legend.fontsize": 7.5,
    "axes.unicode_minus": True,
    "axes.formatter.useoffset": False,
    "grid.color": PALE,
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.1,
    "lines.solid_joinstyle": "round",
}


# Colours for a dark page: background, text, and lighter versions of dark colours.
DARK_GROUND, DARK_INK = "#15181C", "#E8EAED"
DARK = {
    **dict.fromkeys(("figure.facecolor", "axes.facecolor", "savefig.facecolor"), DARK_GROUND),
    **dict.fromkeys(_INKED, DARK_INK),
    "grid.color": "#3A3F45",
}
LIGHTER = {BLUE: "#6FB1E8", RED: "#F0894A", BLACK: DARK_INK, GREEN: "#2FBF95", BROWN: "#C79A6B"}


@record
class Look:
    """The requested form of a picture: width in millimetres, file formats, light or dark page."""

    width: float = 180.0
    formats: tuple[str, ...] = ("svg", "png")
    dark: bool = False

    @property
    def kinds(self) -> tuple[str, ...]:
        """The file formats, always with SVG, since HTML pages need it."""
        return tuple(dict.fromkeys(("svg", *self.formats)))

    @property
    def inches(self) -> float:
        return self.width / 25.4

    @property
    def ink(self) -> str:
        return DARK_INK if self.dark else INK

    @property
    def ground(self) -> str:
        return DARK_GROUND if self.dark else "#FFFFFF"


def written(make: Callable[[Look], Figure], stem: Path, look: Look) -> list[Path]:
    """Writes the figure that `make` draws in this look, as STEM.svg etc.; returns the paths."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    with pyplot.rc_context({**LOOK, **DARK} if look.dark else LOOK):
        figure = make(look)
        files = saved(figure, stem, look.kinds)
        pyplot.close(figure)
    return files


def colour(k: int) -> str:
    return PALETTE[k % len(PALETTE)]


def dashes(k: int, over: bool = False) -> object:
    """Returns the dashes of line k. Lines are solid until colours repeat; with `over`, neighbouring
    lines have different dashes, since they may overlap."""
    return DASHES[(k if over else k // len(PALETTE)) % len(DASHES)]


def encoded(figure: Figure, kind: str, dpi: float = DPI) -> bytes:
    """Returns the figure as a file in one of FORMATS, or OF_LATEX. Raises UsageError."""
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None, "ModDate": None}}
    file = io.BytesIO()
    try:
        figure.savefig(file, format=kind, dpi=dpi, metadata=dates.get(kind))
    except (FileNotFoundError, RuntimeError) as error:
        if kind != OF_LATEX:
            raise
        raise UsageError(f"a picture as pgf needs xelatex: {str(error).splitlines()[0]}") from None
    found = file.getvalue()
    return tidy(found.decode()).encode() if kind == "svg" else found


def saved(figure: Figure, stem: Path, kinds: Iterable[str], dpi: float = DPI) -> list[Path]:
    """Writes the figure as STEM.svg etc., in formats of FORMATS or OF_LATEX; returns the paths."""
    files = [stem.with_name(f"{stem.name}.{kind}") for kind in kinds]
    for path in files:
        path.write_bytes(encoded(figure, path.suffix[1:], dpi))
    return files


def tidy(svg: str) -> str:
    """Returns an SVG with fallback fonts added, and with coordinates rounded to 1/100 point. In
    most files, digits of coordinates take half of the bytes."""
    return re.sub(
        r'(?<= )(?:d|x|y|transform)="[^"]*"',
        lambda attribute: re.sub(r"(\.\d\d)\d+", r"\1", attribute[0]),
        svg.replace("'DejaVu Sans'", FONTS),
    )
