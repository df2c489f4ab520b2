"""Text into C safely: comments, string literals, and lines folded at 100 columns."""

from __future__ import annotations

import re
import textwrap
import unicodedata

WIDTH = 98
_LONGEST_STRING = 500
_ESCAPES = {'"': '\\"', "\\": "\\\\"}
_INVISIBLE = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}  # bidirectional marks among them


def visible(text: str) -> str:
    """One line, without control characters and without marks that reorder what is shown."""
    text = " ".join(text.split())
    return "".join("?" if unicodedata.category(c) in _INVISIBLE else c for c in text)


def comment(text: str) -> str:
    """Text for the inside of a block comment: it can neither end nor nest it, nor be spliced."""
    text = re.sub(r"\*(?=/)|/(?=\*)|\?(?=\?)", r"\g<0> ", visible(text))
    return text.replace("\\", "/")


def string(text: str) -> str:
    """A C string literal; what is not ASCII becomes the octal bytes of its UTF-8."""
    text = visible(text)
    if len(text) > _LONGEST_STRING:
        text = text[: _LONGEST_STRING - 3] + "..."
    parts = []
    for c in text:
        if c == "?":  # two of them could be a trigraph
            parts.append("\\?" if parts and parts[-1].endswith("?") else "?")
        elif c.isascii():
            parts.append(_ESCAPES.get(c, c))
        else:
            parts.extend(f"\\{byte:03o}" for byte in c.encode())
    return '"' + "".join(parts) + '"'


def paragraph(text: str, first: str = " * ", rest: str = " * ", width: int = WIDTH) -> str:
    """Words folded behind a comment's left margin."""
    lines = textwrap.wrap(
        text,
        width,
        initial_indent=first,
        subsequent_indent=rest,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return "\n".join(line.rstrip() for line in lines) if lines else first.rstrip()


_BREAK = re.compile(r" (?=[-+*/|] )| (?=&& )|(?<=,) ")


def fold(line: str, indent: int = 0, hang: int = 4) -> str:
    """A statement folded before operators and after commas, at the outermost brackets there are
    in reach; what follows is indented by `hang` more."""
    line = " " * indent + line
    lines = []
    while len(line) > WIDTH:
        at = _best_break(line)
        if at is None:
            break
        lines.append(line[:at])
        line = " " * (indent + hang) + line[at + 1 :]
    return "\n".join([*lines, line])


def fold_call(line: str, indent: int = 0) -> str:
    """The same for a call or a declaration: what follows stands under the first argument."""
    return fold(line, indent, line.index("(") + 1)


def _best_break(line: str) -> int | None:
    """Where to break: outside most brackets, rather before a sum's sign than a product's, and
    of such places the last; not in the line's first part if that can be."""
    start = len(line) - len(line.lstrip())
    depths, depth = [], 0
    for c in line[: WIDTH + 1]:
        depth += (c == "(") - (c == ")")
        depths.append(depth)
    places = [m.start() for m in _BREAK.finditer(line) if start < m.start() <= WIDTH]
    late = [at for at in places if at > start + (WIDTH - start) * 2 // 5] or places
    return min(late, key=lambda at: (depths[at], line[at + 1] in "*/", -at), default=None)
