"""A small syntax tree of C, statements and functions, and their text, folded and indented.

A statement is its text, of one line or several. Blocks are nodes: kernels, loops and checks
are built of both; the rest of a file is in Jinja2 templates.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...record import record
from .ctext import fold, fold_call, paragraph


def Declare(type: str, name: str, value: str = "") -> str:
    text = f"{type} {name}" if type[-1] != "*" else f"{type}{name}"
    return f"{text} = {value};" if value else f"{text};"


@record
class If:
    condition: str
    body: Sequence[Node]


@record
class Loop:
    """A loop; `head` is the text in the parentheses of `for`."""

    head: str
    body: Sequence[Node]


@record
class Scope:
    """Statements in a block of their own, { ... }."""

    body: Sequence[Node]


@record
class Text:
    """Lines of C, copied without indentation."""

    text: str


Node = str | If | Loop | Scope | Text


@record
class Function:
    """A function. `says` is its comment; `before` a line before its type, such as PK_INLINE."""

    signature: str
    body: Sequence[Node]
    says: str = ""
    before: str = ""

    @property
    def text(self) -> str:
        lines = [f"{paragraph(self.says, '/* ')} */"] if self.says else []
        lines += [self.before] if self.before else []
        return "\n".join([*lines, fold_call(self.signature), "{", *rendered(self.body), "}", ""])


def rendered(nodes: Iterable[Node], indent: int = 4) -> list[str]:
    """Returns the C lines of the nodes; a folded statement is one entry with several lines."""
    return [line for node in nodes for line in _lines(node, indent)]


def _lines(node: Node, indent: int) -> list[str]:
    margin = " " * indent
    match node:
        case str():
            lines = ((line, line.lstrip()) for line in node.split("\n"))
            return [text and fold(text, indent + len(line) - len(text)) for line, text in lines]
        case If(condition, body):
            return _headed(f"if ({condition})", body, indent)
        case Loop(head, body):
            return _headed(f"for ({head})", body, indent)
        case Scope(body):
            return [margin + "{", *rendered(body, indent + 4), margin + "}"]
        case Text(text):
            return [text.rstrip("\n")]


def _headed(head: str, body: Sequence[Node], indent: int) -> list[str]:
    """Returns a head, such as `if (x)`, and its body; braces are left out around one statement."""
    if len(body) == 1 and isinstance(body[0], Scope):
        body = body[0].body
    lines = rendered(body, indent + 4)
    if len(body) == 1:
        return [fold(head, indent), *lines]
    return [fold(head, indent) + " {", *lines, " " * indent + "}"]
