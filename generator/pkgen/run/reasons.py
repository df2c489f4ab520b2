"""The runtime's reasons with the options of `pkgen run` that they are about.

The runtime says what is to change, in words that also serve a program of one's own; here, and here
alone, stands which option that is.
"""

from __future__ import annotations

import re

OPTIONS = {
    "a largest step": "--max-step",
    "a smaller tolerance": "--rtol",
    "a first step": "--step",
    "use Newton's": "--iteration newton",
    "too many steps": "--max-steps",
    "make the step shorter": "--step",
    "make the steps shorter": "--step, --rtol",
}
_ANY = re.compile("|".join(map(re.escape, OPTIONS)))


def with_options(text: str) -> str:
    """Each option behind the words that are about it."""
    return _ANY.sub(lambda found: f"{found[0]} ({OPTIONS[found[0]]})", text)
