"""The promises of docs/dev/compatibility.md: older texts mean the same, and a number goes
with what it numbers."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
from importlib import import_module
from pathlib import Path

import pytest

from conftest import ROOT, run_pkgen
from pkgen import __version__
from pkgen.describe.describe import SCHEMA

TEXTS = Path(__file__).parent / "texts"
PAGE = (ROOT / "docs/dev/compatibility.md").read_text(encoding="utf-8")
KINDS = ("text", "lag")
QUICK = ("mixed", "thrown_stone")
# Of each number of an ABI what it numbers: the first digits of a digest of pk/system.h without
# comments. A new layout needs new numbers in pk/system.h.
LAYOUTS = {92: "32debf73dc9a"}


def frozen() -> list[Path]:
    return sorted(TEXTS.glob("*/*.lag"))


def meant(path: Path) -> dict[str, object]:
    """What a text says in numbers: columns, and their values at the start and later."""
    how = ("--until", "0.25", "--every", "0.25", "--rtol", "1e-12", "--json")
    done = run_pkgen("run", path, *how)
    assert done.returncode == 0, done.stderr or done.stdout
    found = json.loads(done.stdout)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    names = [column["name"] for column in found["columns"]]
    return {"sha256": digest, "columns": names, "rows": found["rows"]}


def kept(version: Path) -> dict:
    place = version / "means.json"
    return json.loads(place.read_text(encoding="utf-8")) if place.exists() else {}


@pytest.mark.parametrize(
    "path",
    frozen(),
    ids=lambda p: f"{p.parent.name}-{p.stem}",
)
def test_a_text_of_an_earlier_version_means_the_same(path: Path) -> None:
    known, now = kept(path.parent), meant(path)
    if path.stem not in known and os.environ.get("PKGEN_UPDATE"):
        known[path.stem] = now
        text = json.dumps(dict(sorted(known.items())), indent=1)
        (path.parent / "means.json").write_text(text + "\n", encoding="utf-8")
    then = known[path.stem]
    assert now["sha256"] == then["sha256"], "a frozen text is never changed"
    assert now["columns"] == then["columns"]
    for row, other in zip(now["rows"], then["rows"], strict=True):
        assert row == pytest.approx(other, rel=1e-8, abs=1e-9)
    done = run_pkgen("check", path, "--json")
    errors = [d for d in json.loads(done.stdout)["diagnostics"] if d["severity"] == "error"]
    assert done.returncode == 0 and errors == []


@pytest.mark.needs_addon("editor")
def test_no_word_of_an_earlier_version_is_gone() -> None:
    words = import_module("pkgen_editor.words").words()
    versions = sorted(TEXTS.iterdir())
    assert versions[-1].name == __version__.rpartition(".")[0], "freeze texts of this version"
    for version in versions:
        then = json.loads((version / "words.json").read_text(encoding="utf-8"))
        assert sum(map(len, then.values())) > 100
        for kind, known in then.items():
            assert set(known) - set(words[kind]) == set(), kind


def layout() -> str:
    """pk/system.h and what it includes of ours, as the compiler sees it."""
    text = "#include <pk/system.h>\n"
    command = ["gcc", "-E", "-I", ROOT / "runtime/include", "-x", "c", "-"]
    said = subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout
    ours, lines = False, []
    for line in said.splitlines():
        if line.startswith("# "):
            ours = "/runtime/include/pk/" in line
        elif ours:
            lines.append(line)
    return " ".join(" ".join(lines).split())


def test_a_layout_has_its_number() -> None:
    header = (ROOT / "runtime/include/pk/system.h").read_text(encoding="utf-8")
    numbers = [int(n) for n in re.findall(r"#define PK_ABI (\d+)u", header)]
    assert len(set(numbers)) == 4
    text = layout()
    assert "struct pk_system {" in text and "/*" not in text
    digest = hashlib.sha256(text.encode()).hexdigest()[:12]
    assert {numbers[-1]: digest} == LAYOUTS, "four new numbers, and this digest beside the last"


def test_the_page_has_the_numbers() -> None:
    number = next(iter(LAYOUTS))
    assert f"`PK_ABI` {number}" in PAGE and f"`schema` {SCHEMA}" in PAGE
    assert f"pkgen {__version__}\n" in PAGE


def test_the_page_of_installing_shows_what_is_printed(write) -> None:
    page = (ROOT / "docs/install.md").read_text(encoding="utf-8")
    (shown,), (model,) = (re.findall(rf"^```{k}\n(.*?)^```", page, re.M | re.S) for k in KINDS)
    commands = [line.split()[1:] for line in shown.splitlines() if line.startswith("$ ")]
    assert [c[:2] for c in commands] == [["pip", "install"], ["pkgen", "-V"], ["pkgen", "run"]]
    assert f"\npkgen {__version__}\n" in shown and f"/pkgen_lag-{__version__}-py3" in shown
    rows = shown.splitlines()[-4:]
    done = run_pkgen("run", write(model), *commands[2][3:])
    printed = done.stdout.splitlines()
    assert printed[0] == rows[0] and len(printed) == 4, done.stderr
    for line, other in zip(printed[1:], rows[1:], strict=True):
        one, two = ([float(x) for x in row.split(",")] for row in (line, other))
        assert one == pytest.approx(two, rel=1e-9)


def test_the_package_of_debian_has_the_version() -> None:
    changelog = (ROOT / "debian/changelog").read_text(encoding="utf-8")
    assert changelog.startswith(f"pkgen ({__version__}) ")
