"""docs/tutorial.md as a newcomer follows it: every file, edit and command, in order, as text."""

import re
import shlex
import subprocess
from pathlib import Path

from conftest import ROOT, run_pkgen

FENCE = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
MODEL = "swinging_atwood.lag"


class Newcomer:
    """Does what the blocks of the page say, in one folder."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.commands = 0

    def lag(self, text: str) -> None:
        (self.folder / MODEL).write_text(text)

    def c(self, text: str) -> None:
        assert text.startswith("/* main.c")
        (self.folder / "main.c").write_text(text)

    def diff(self, text: str) -> None:
        """Lines with - are replaced by those with +; + alone stands at the end."""
        path = self.folder / MODEL
        old = "".join(f"{x[1:]}\n" for x in text.splitlines() if x[0] == "-")
        new = "".join(f"{x[1:]}\n" for x in text.splitlines() if x[0] == "+")
        before = path.read_text()
        assert not old or before.count(old) == 1, old
        path.write_text(before.replace(old, new) if old else before + new)

    def console(self, text: str) -> None:
        shown: dict[str, list[str]] = {}
        for line in text.splitlines():
            if line.startswith("$ "):
                shown[line[2:]] = []
            else:
                shown[list(shown)[-1]].append(line)
        for command, expected in shown.items():
            compare(self.said(shlex.split(command)), expected, command)
            self.commands += 1

    def said(self, words: list[str]) -> list[str]:
        if words[0] == "pkgen":
            done = run_pkgen(*words[1:], cwd=self.folder)
        else:
            done = subprocess.run(
                words, cwd=self.folder, capture_output=True, text=True, check=False
            )
        return (done.stdout + done.stderr).splitlines()


def compare(said: list[str], shown: list[str], command: str) -> None:
    """Line by line; a line of … stands for any number of lines."""
    place = 0
    for i, line in enumerate(shown):
        if line == "…":
            continue
        anywhere = i > 0 and shown[i - 1] == "…"
        places = range(place, len(said) if anywhere else place + 1)
        found = next((k for k in places if k < len(said) and alike(said[k], line)), None)
        assert found is not None, f"$ {command}\nshown: {line}\nsaid:  {said[place : place + 3]}"
        place = found + 1
    assert place == len(said) or shown[-1:] == ["…"], f"$ {command}\nmore: {said[place:]}"


def alike(said: str, shown: str) -> bool:
    """Words the same, numbers to the digits shown, … at the end for the rest of the line."""
    if shown.endswith("…"):
        shown = shown.removesuffix("…")
        said = said[: len(shown)] if not NUMBER.search(shown) else cut(said, shown)
    if NUMBER.sub("#", said) != NUMBER.sub("#", shown):
        return False
    pairs = zip(NUMBER.findall(said), NUMBER.findall(shown), strict=True)
    return all(abs(float(a) - float(b)) <= 0.6 * unit(b) for a, b in pairs)


def cut(said: str, shown: str) -> str:
    """As many words as are shown."""
    return " ".join(said.split(" ")[: len(shown.rstrip().split(" "))]) + " " * shown.endswith(" ")


def unit(number: str) -> float:
    """Of the last digit."""
    digits, _, exponent = number.partition("e")
    decimals = len(digits.partition(".")[2])
    return 10.0 ** (int(exponent or 0) - decimals)


def test_a_newcomer_follows_the_tutorial(tmp_path: Path) -> None:
    newcomer = Newcomer(tmp_path)
    for language, text in FENCE.findall((ROOT / "docs/tutorial.md").read_text()):
        getattr(newcomer, language)(text)
    assert newcomer.commands >= 11
    assert (tmp_path / "swing.csv").stat().st_size > 1000


def test_what_differs_is_seen() -> None:
    assert alike("drift(energy) max 1.5e-11, final", "drift(energy) max …")
    assert alike("1,0.57082602269,2", "1,0.570826,2")
    assert not alike("1,0.57082602269,2", "1,0.570828,2")
    assert not alike("expected: 2 of 3 met", "expected: 3 of 3 met")
    assert not alike("an error", "an eror")
