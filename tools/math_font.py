"""The part of STIX that formulas are set in: addons/pages/pkgen_pages/explain/fonts/math.woff2.

    python tools/math_font.py STIXMath-Regular.otf    # of Debian's fonts-stix

Wants fonttools and brotli. Kept are the letters and signs that explain/mathml.py and typeset.py
write, and the table MATH by which browsers place what is stacked and make brackets grow. The
licence wants another name for what was changed. The result depends on its source alone.
"""

from __future__ import annotations

import sys
from pathlib import Path

from fontTools import subset
from fontTools.ttLib import TTFont

OUT = Path(__file__).parents[1] / "addons/pages/pkgen_pages/explain/fonts/math.woff2"
NAME = "pkgen math"
LETTERS = [
    *range(0x20, 0x7F),
    *map(ord, "\u00a0¨¬±²³·¹×÷ı˙ˆ˜‖′″‴…→⇒∀∂∅∇∈∏∑−√∝∞∠∥∫≈≠≤≥≪≫⊥⋅⋮⋯⌈⌉⌊⌋⟨⟩ℎ⁰⁴⁵⁶⁷⁸⁹⁻"),
    *range(0x300, 0x309),
    *range(0x391, 0x3AA),
    *range(0x3B1, 0x3CA),
    *range(0x2061, 0x2064),
    *range(0x1D400, 0x1D49C),  # bold, italic, both
    *range(0x1D6A8, 0x1D756),  # Greek likewise
]


def main(source: str) -> None:
    options = subset.Options()
    options.layout_features = ["math", "ssty", "dtls", "flac", "kern"]
    options.flavor, options.name_IDs, options.recalc_timestamp = (
        "woff2",
        [0, 1, 2, 4, 6, 13, 14],
        False,
    )
    font = TTFont(source, recalcTimestamp=False)
    for record in font["name"].names:
        if record.nameID in (1, 4):
            record.string = NAME
        if record.nameID == 6:
            record.string = NAME.replace(" ", "-")
    subsetter = subset.Subsetter(options)
    subsetter.populate(unicodes=LETTERS)
    subsetter.subset(font)
    subset.save_font(font, str(OUT), options)
    print(f"{OUT.name}: {OUT.stat().st_size:,} bytes")


if __name__ == "__main__":
    main(sys.argv[1])
