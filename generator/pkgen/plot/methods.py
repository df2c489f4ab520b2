"""The colour and the marker of each method, the same in all pictures."""

from __future__ import annotations

from zlib import crc32

from .style import BLACK, BLUE, BROWN, GREEN, LIGHTER, ORANGE, PURPLE, RED, SKY

# The methods that have each colour. Methods that are often compared have different colours; methods
# of the same colour have different markers.
TABLE = {
    BLUE: "gauss verlet rk2 yoshida8 boris6 rattle6 gsl_msbdf",
    RED: "dopri5 gauss2 yoshida4 gsl_rkf45 respa lobatto4 rattle",
    GREEN: "gsl_rk8pd blanes_moan4 rk4 lobatto2 boris lie_midpoint",
    PURPLE: "dop853 rk3 gauss1 kahan_li6 lobatto3 rattle4 gsl_bsimp",
    ORANGE: "rkmk8 radau9 euler respa4 lie_midpoint6 gsl_msadams stochastic_verlet",
    SKY: "gauss3 blanes_moan6 gauss8 rkmk4 mclachlan4 boris4 taylor",
    BLACK: "gauss4 gauss6 yoshida6 symplectic_euler adaptive_verlet lie_midpoint4 radau baoab",
    BROWN: "gauss5 gauss7 kahan_li8 radau5 suzuki4 exponential heun",
}
MARKERS = "osD^vPX*"
OTHERS = "<>ph"  # markers of methods of a model or of other packages
MARKS = {
    name: (colour, MARKERS[(row + k) % len(MARKERS)])
    for row, (colour, names) in enumerate(TABLE.items())
    for k, name in enumerate(names.split())
}


def mark(name: str, dark: bool = False) -> tuple[str, str]:
    """Returns the colour and the marker of a method."""
    code, colours = crc32(name.encode()), tuple(TABLE)
    other = colours[code % len(colours)], OTHERS[code // len(colours) % len(OTHERS)]
    colour, marker = MARKS.get(name, other)
    return (LIGHTER.get(colour, colour) if dark else colour), marker
