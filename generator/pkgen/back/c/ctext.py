"""Makes text safe in C: comments, string literals, and lines folded at 100 columns."""

from __future__ import annotations

import re
import textwrap
import unicodedata

WIDTH = 98
_LONGEST_STRING = 500
_ESCAPES = {'"': '\\"', "\\": "\\\\"}
_INVISIBLE = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}  # Cf: bidirectional marks


def visible(text: str) -> str:
    """Returns the text on one line, with ? for control and bidirectional characters."""
    text = " ".join(text.split())
    return "".join("?" if unicodedata.category(c) in _INVISIBLE else c for c in text)


def comment(text: str) -> str:
    """Returns text that cannot end a block comment, nest another in it or splice lines."""
    text = re.sub(r"\*(?=/)|/(?=\*)|\?(?=\?)", r"\g<0> ", visible(text))
    return text.replace("\\", "/")


def string(text: str) -> str:
    """Returns a C string literal; non-ASCII characters become octal escapes of UTF-8 bytes."""
    text = visible(text)
    if len(text) > _LONGEST_STRING:
        text = text[: _LONGEST_STRING - 3] + "..."
    parts = []
    for c in text:
        if c == "?":  # "??" may begin a trigraph.
            parts.append("\\?" if parts and parts[-1].endswith("?") else "?")
        elif c.isascii():
            parts.append(_ESCAPES.get(c, c))
        else:
            parts.extend(f"\\{byte:03o}" for byte in c.encode())
    return '"' + "".join(parts) + '"'


def paragraph(text: str, first: str = " * ", rest: str = " * ") -> str:
    """Returns the text folded into lines. The first line begins with `first`, others with
    `rest`."""
    lines = textwrap.wrap(
        text,
        WIDTH - 3,  # Space for `*/`.
        initial_indent=first,
        subsequent_indent=rest,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return "\n".join(line.rstrip() for line in lines) if lines else first.rstrip()


_STRING = re.compile(r'"(?:[^"\\]|\\.)*"')  # String literals must not be broken.
_BREAK = re.compile(r" (?=[-+*/|] )| (?=&& )|(?<=,) ")


def fold(line: str, indent: int = 0, hang: int = 4) -> str:
    """Returns a statement folded into lines: before operators and after commas, where the depth of
    nested brackets is least. Continuation lines are indented by `hang` more than the first."""
    line = " " * indent + line
    if len(line) <= WIDTH:
        return line
    lines = []
    while len(line) > WIDTH:
        at = _best_break(line)
        if at is None:
            break
        lines.append(line[:at])
        line = " " * (indent + hang) + line[at + 1 :]
    return "\n".join([*lines, line])


def fold_call(line: str, indent: int = 0) -> str:
    """Returns a folded declaration; if possible, lines align with the first argument."""
    hang = line.index("(") + 1
    return fold(line, indent, hang if hang <= WIDTH // 2 else 4)


def _best_break(line: str) -> int | None:
    """Returns the position of the best line break, if possible not near the line's beginning. The
    best break has the least depth of brackets; among equals a break before + or - is better than
    one before * or /, and then the last one is best."""
    start = len(line) - len(line.lstrip())
    strings = [m.span() for m in _STRING.finditer(line)]
    every = [
        m.start()
        for m in _BREAK.finditer(line)
        if m.start() > start and not any(lo < m.start() < hi for lo, hi in strings)
    ]
    places = [at for at in every if at <= WIDTH]
    if not places:
        return every[0] if every else None
    late = [at for at in places if at > start + (WIDTH - start) * 2 // 5] or places

    def rank(at: int) -> tuple[int, bool, int]:
        return line.count("(", 0, at) - line.count(")", 0, at), line[at + 1] in "*/", -at

    return min(late, key=rank, default=None)
