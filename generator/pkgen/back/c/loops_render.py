"""LoopProgram -> {file name: text}."""

from __future__ import annotations

from .loop_code import LoopCode
from .loops_lower import LoopProgram
from .render import environment


def render_loops(program: LoopProgram) -> dict[str, str]:
    """NAME.h and NAME.c."""
    context = program.context | {"loops": LoopCode(program.name)}
    templates = {"h": "loop_header.h.j2", "c": "loop_source.c.j2"}
    return {
        f"{program.name}.{kind}": environment().get_template(template).render(context)
        for kind, template in templates.items()
    }
