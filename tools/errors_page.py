"""Write docs/dev/results/errors.md: each wrong model of the tests with what pkgen says of it.

`make golden` runs it, behind the tests whose messages it shows.
"""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WRONG = ROOT / "tests" / "generator" / "wrong"
PAGE = ROOT / "docs/dev/results/errors.md"
INTRODUCTION = """# What wrong models are told

Every message has its place, the line with a caret, and where one is known a way to mend it; all
that can be found is reported in one run. This page is a reference, not for reading through:
`make golden` makes it from the wrong models of the tests (`tests/generator/wrong`), which compare
each message to the letter. Larger ones (10 MB, brackets 10,000 deep, a sum of 200,000 terms) are
in the tests of the parser; what they meet stands in [limits](../../language.md#limits).
"""


def page() -> str:
    """The page's text."""
    parts = [INTRODUCTION]
    for expected in sorted(WRONG.glob("*.txt")):
        title = expected.stem.replace("_", " ")
        parts.append(f"## {title.capitalize()}\n\n```text\n{expected.read_text().rstrip()}\n```\n")
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
