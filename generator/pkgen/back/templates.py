"""Text of exports from templates in the folder of a host."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import jinja2


def filled(folder: Path, template: str, **context: object) -> str:
    return _environment(folder).get_template(template).render(context)


@cache
def _environment(folder: Path) -> jinja2.Environment:
    import jinja2  # as in back/c/render.py

    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
