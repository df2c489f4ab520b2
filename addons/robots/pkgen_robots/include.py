"""Replaces each <include> of MJCF by the content of the included file."""

from __future__ import annotations

import os

from pkgen import limits
from pkgen.front.read import read_text, refusal
from pkgen.source import ModelError

from .xml import Element, Errors, tree


def spliced(root: Element, errors: Errors) -> None:
    """Replaces each <include> by the children of the included file's root. Only files in the folder
    of the first file, or below it, are read, each once."""
    path = root.source.path
    folder, seen, count = os.path.dirname(path), {os.path.realpath(path)}, 0
    waiting = [(root, folder)]
    while waiting:
        element, beside = waiting.pop()
        pending = [(child, beside) for child in reversed(element.children)]
        element.children = []
        while pending:
            child, beside = pending.pop()
            count += 1
            if count > limits.XML_ELEMENTS:
                raise child.wrong(f"more than {limits.XML_ELEMENTS} elements with those included")
            if child.tag != "include":
                element.children.append(child)
                waiting.append((child, beside))
                continue
            with errors.collecting():
                file = _file(child, folder, beside)
                if os.path.realpath(file) in seen:
                    raise child.wrong(f"'{child.text('file')}' is included twice")
                seen.add(os.path.realpath(file))
                inside, below = _tree(child, file), os.path.dirname(file)
                pending += [(part, below) for part in reversed(inside.children)]


def _file(include: Element, folder: str, beside: str) -> str:
    """Returns the path of an included file, relative to the first or to the including file."""
    named = include.text("file")
    places = [os.path.join(place, named) for place in (folder, beside)]
    file = next((place for place in places if os.path.exists(place)), places[0])
    why = refusal(named, file, folder)
    if why:
        raise include.wrong(why, "copy it there")
    if not os.path.isfile(file):
        raise include.wrong(f"there is no file '{named}' beside this one")
    return file


def _tree(include: Element, file: str) -> Element:
    """Returns the root of a file; errors in it are shown at its <include>."""
    try:
        source = read_text(file, "an MJCF file")
        top = tree(source)
    except ModelError as error:
        (found,) = error.diagnostics
        line, column = error.source.position(found.span.start)
        message = f"{include.text('file')}:{line}:{column}: {found.message}"
        raise include.wrong(message, found.help) from None
    waiting = [top]
    while waiting:
        element = waiting.pop()
        line, column = source.position(element.span.start)
        element.where = f"{include.text('file')}:{line}:{column}"
        element.source, element.span = include.source, include.span
        waiting += element.children
    return top
