"""Jinja templates of C and of exports; each is in the folder of its module."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import jinja2


def filled(folder: Path, template: str, **context: object) -> str:
    return environment(folder).get_template(template).render(context)


@cache
def environment(folder: Path) -> jinja2.Environment:
    import jinja2  # Loading jinja2 takes longer than checking a model.

    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
