"""Commands and their messages: each page beside this file is a list of them.

A page has files (`--- NAME`, then the text), commands (`$ run …`), and below each its exit code and
what it says; behind ` | ` stands what those lines of its output have that are shown (`> `). Files
stay until another of their name comes. Words are compared as they are, numbers to four digits;
lines about the length of a run are left out. `make golden` writes pages anew.
"""

import os
import re
import shlex
from pathlib import Path

import pytest

from conftest import ROOT, run_pkgen

PAGES = sorted(Path(__file__).parent.glob("*.txt"))
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]\d+)?")
# Lines about the length of a run, and about rounding.
LENGTHS = re.compile(
    r"\d rejected|^energy |\d ms|^run: at t = .* of |random walk|compil\w+ the runtime"
)
MARKS = ("=== ", "--- ", "$ ")
SMALL = 1e-9  # numbers below are rounding


def blocks(page: Path) -> list[tuple[str, list[str]]]:
    """The marked lines of a page, each with the lines below it."""
    found: list[tuple[str, list[str]]] = []
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith(MARKS):
            found.append((line, []))
        else:
            found[-1][1].append(line)
    return found


def cases() -> list:
    found = []
    for page in PAGES:
        files: dict[str, str] = {}
        for mark, lines in blocks(page):
            if mark.startswith("--- "):
                files[mark[4:]] = "".join(f"{line}\n" for line in lines)
            if mark.startswith("$ "):
                name = f"{page.stem}-{len(found)}"
                found.append(pytest.param(page, mark[2:], dict(files), lines, id=name))
    return found


def said(words: str, files: dict[str, str], folder: Path) -> list[str]:
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    words, _, shown = words.partition(" | ")
    done = run_pkgen(*shlex.split(words.replace("$ROOT", str(ROOT))), cwd=folder)
    lines = [line for line in done.stderr.splitlines() if not LENGTHS.search(line)]
    lines += [f"> {line}" for line in done.stdout.splitlines() if shown and shown in line]
    lines = [line.replace(f"{folder}/", "").replace(str(ROOT), "$ROOT") for line in lines]
    return [f"exit {done.returncode}{', rows' * bool(done.stdout)}", *lines]


def numbers(lines: list[str]) -> list[float]:
    found = [float(x) for x in NUMBER.findall("\n".join(lines))]
    return [0.0 if abs(x) < SMALL else x for x in found]


@pytest.mark.parametrize(("page", "words", "files", "wanted"), cases())
def test_each_says_what_its_page_has(page, words, files, wanted, tmp_path) -> None:
    found = said(words, files, tmp_path)
    same = [NUMBER.sub("#", x) for x in found] == [NUMBER.sub("#", x) for x in wanted]
    same &= numbers(found) == pytest.approx(numbers(wanted), rel=1e-4)
    if not same and os.environ.get("PKGEN_UPDATE"):
        text = page.read_text(encoding="utf-8")
        before, after = ("\n".join(("", f"$ {words}", *x, "")) for x in (wanted, found))
        page.write_text(text.replace(before, after, 1), encoding="utf-8")
        return
    assert same, "\n".join(found)
