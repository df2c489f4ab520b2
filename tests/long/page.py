"""docs/dev/long-runs.md: what the long tests measured, a section each (PKGEN_UPDATE=1)."""

import os
import re

from conftest import ROOT

PAGE = ROOT / "docs/dev/long-runs.md"


def write_section(title: str, text: str) -> None:
    """Put the section in its place, which is at the end if it is new; the others stay."""
    if not os.environ.get("PKGEN_UPDATE"):
        return
    parts = re.split(r"^# (.*)\n\n", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    sections = dict(zip(parts[1::2], (part.strip() for part in parts[2::2]), strict=True))
    sections[title] = text.strip()
    page = "\n\n".join(f"# {name}\n\n{body}" for name, body in sections.items())
    PAGE.write_text(page + "\n", encoding="utf-8")
