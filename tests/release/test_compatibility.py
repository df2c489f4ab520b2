"""The promises of docs/dev/compatibility.md: older texts mean the same, and a number goes
with what it numbers."""

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
LAYOUT = Path(__file__).parent / "layout.json"


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


def shared() -> str:
    """The headers that models and the runtime share, as the compiler sees them."""
    text = "#include <pk/step/block.h>\n"
    command = ["gcc", "-E", "-I", ROOT / "runtime/include", "-x", "c", "-"]
    said = subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout
    ours, lines = False, []
    for line in said.splitlines():
        if line.startswith("# "):
            ours = "/runtime/include/pk/" in line
        elif ours:
            lines.append(line)
    return "\n".join(lines)


def layout(folder: Path) -> dict[str, list[int]]:
    """Offset and size of each member, "struct.member"; the size of each struct; each enumerator."""
    text, prints = shared(), []
    for struct, body in re.findall(r"^struct (pk_\w+) \{(.*?)^\};", text, re.S | re.M):
        prints.append((f"struct {struct}", f"0, sizeof(struct {struct})"))
        for declared in body.split(";")[:-1]:
            names = re.findall(r"\(\*(\w+)\)\(", declared) or re.findall(
                r"(\w+)(?:\[[^\]]*\])*\s*(?:,|$)", declared
            )
            for name in names:
                member = f"((struct {struct} *)0)->{name}"
                prints.append((f"{struct}.{name}", f"(size_t)&{member}, sizeof {member}"))
    for body in re.findall(r"enum \w* ?\{(.*?)\}", text, re.S):
        for name in re.findall(r"\bPK_\w+(?=\s*(?:,|=|$))", body):
            prints.append((name, f"(size_t){name}, 0"))
    lines = [f'printf("{name}\\t%zu\\t%zu\\n", {values});' for name, values in prints]
    code = "\n".join(
        ["#include <stdio.h>", "#include <pk/step/block.h>", "int main(void) {", *lines, "}"]
    )
    program = folder / "layout"
    command = ["gcc", "-w", "-I", ROOT / "runtime/include", "-x", "c", "-", "-o", program]
    subprocess.run(command, input=code, text=True, check=True)
    said = subprocess.run([program], capture_output=True, text=True, check=True).stdout
    return {
        name: [int(x) for x in values]
        for name, *values in (line.split("\t") for line in said.splitlines())
    }


def test_a_layout_has_its_number(tmp_path: Path) -> None:
    """Members may be appended to struct pk_system; all else that moves needs another number."""
    header = (ROOT / "runtime/include/pk/system.h").read_text(encoding="utf-8")
    (number,) = map(int, re.findall(r"#define PK_ABI_VERSION (\d+)u", header))
    now = layout(tmp_path)
    assert len(now) > 400 and now["pk_system.abi"] == [0, 4]
    if os.environ.get("PKGEN_UPDATE"):
        lines = ",\n".join(f' "{name}": {values}' for name, values in now.items())
        LAYOUT.write_text(f'{{\n "version": {number},\n{lines}\n}}\n', encoding="utf-8")
    then = json.loads(LAYOUT.read_text(encoding="utf-8"))
    version, grows = then.pop("version"), "struct pk_system"
    end = then.pop(grows)[1]
    moved = {name for name, values in then.items() if now.get(name) != values}
    inside = {n for n in now if n.startswith("pk_system.") and n not in then and now[n][0] < end}
    if number == version:
        assert not moved | inside, "raise PK_ABI_VERSION in pk/system.h, then set PKGEN_UPDATE=1"
    assert (number, now.pop(grows)[1], now) == (version, end, then), (
        "set PKGEN_UPDATE=1 to keep the new members where they are from now on"
    )


def test_the_page_has_the_numbers() -> None:
    number = json.loads(LAYOUT.read_text(encoding="utf-8"))["version"]
    assert f"`PK_ABI_VERSION` {number}" in PAGE and f"`schema` {SCHEMA}" in PAGE
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
