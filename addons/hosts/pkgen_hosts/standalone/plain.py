"""Evaluates #ifdef conditions in C text."""

from __future__ import annotations

import re
from collections.abc import Mapping

_DIRECTIVE = re.compile(r"\s*#\s*(ifdef|ifndef|if|elif|else|endif)\b\s*(\w*)")


def plain(text: str, known: Mapping[str, bool]) -> str:
    """Returns C text in which each `#ifdef NAME` whose NAME is in `known` is replaced by the branch
    that the preprocessor would take."""
    lines: list[str] = []
    kept: list[bool | None] = []  # values of enclosing #ifs; None if unknown
    for line in text.splitlines():
        found = _DIRECTIVE.match(line)
        word, name = (found[1], found[2]) if found else ("", "")
        if word in ("ifdef", "ifndef", "if"):
            mine = word != "if" and name in known
            kept.append(known[name] == (word == "ifdef") if mine else None)
            if mine:
                continue
        elif word in ("else", "endif") and kept[-1] is not None:
            kept[-1] = not kept[-1]
            if word == "endif":
                kept.pop()
            continue
        elif word == "endif":
            if False not in kept:
                lines.append(line)
            kept.pop()
            continue
        if False not in kept:
            lines.append(line)
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)) + "\n"
