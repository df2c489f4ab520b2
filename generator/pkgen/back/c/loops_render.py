"""LoopProgram -> {file name: text}."""

from __future__ import annotations

from .loops_lower import LoopProgram
from .render import environment


def render_loops(program: LoopProgram) -> dict[str, str]:
    """NAME.h and NAME.c."""
    templates = {"h": "loop_header.h.j2", "c": "loop_source.c.j2"}
    return {
        f"{program.name}.{kind}": environment().get_template(template).render(program.context)
        for kind, template in templates.items()
    }
