"""Never silent: every case of silence.toml ends by its status, with the last valid time, rows
up to it and none after, and exit code 4; docs/dev/never-silent.md says what is printed to each.

`make golden` (PKGEN_UPDATE=1) writes the page.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest
import tomllib

from conftest import ROOT
from pkgen.__main__ import main

PAGE = ROOT / "docs/dev/never-silent.md"
UPDATE = bool(os.environ.get("PKGEN_UPDATE"))


@dataclass(frozen=True)
class Case:
    what: str
    model: str  # its path
    arguments: str
    status: str
    members: str = ""

    @property
    def text(self) -> str:
        return (ROOT / self.model).read_text(encoding="utf-8")


TABLE = tomllib.loads(Path(__file__).with_name("silence.toml").read_text(encoding="utf-8"))
CASES = {name: Case(**row) for name, row in TABLE.items()}
# A run cannot provoke these, since pkgen's driver sees to them; programs of one's own can.
IN_C = {
    "PK_BAD_ARGUMENT": ("tests/runtime/test_silence.c", "options out of range"),
    "PK_OUT_OF_BOUNDS": ("tests/runtime/test_silence.c", "parameters"),
    "PK_BLOCK_TOO_SMALL": ("tests/runtime/test_status.c", "bad arguments"),
}


@dataclass(frozen=True)
class Outcome:
    report: dict
    rows: list[list[str]]
    said: str
    code: int


@cache
def outcome(name: str) -> Outcome:
    """The command line in this process, since there are many cases."""
    case = CASES[name]
    stdout, stderr = io.StringIO(), io.StringIO()
    with tempfile.TemporaryDirectory() as scratch, redirect_stdout(stdout), redirect_stderr(stderr):
        folder = Path(scratch)
        model, out = folder / f"{model_name(case)}.lag", folder / "rows.csv"
        model.write_text(case.text, encoding="utf-8")
        arguments = [*case.arguments.split(), "--json", "-o", str(out)]
        if case.members:
            (folder / "members.csv").write_text(case.members, encoding="utf-8")
            arguments += ["--ensemble", str(folder / "members.csv"), "--every", "0.5"]
        code = main(["run", str(model), *arguments])
        kept = out if out.exists() else Path(f"{out}.partial")  # neither without a row
        rows = list(csv.reader(kept.read_text().splitlines()))[1:] if kept.exists() else []
    report = json.loads(stdout.getvalue())["report"]
    lines = stderr.getvalue().splitlines()
    said = [x for x in lines if x.startswith("run: ") and not x.startswith("run: warning: ")]
    assert len(said) == 1, stderr.getvalue()
    return Outcome(report, rows, said[0].removeprefix("run: "), code)


def model_name(case: Case) -> str:
    return case.text.split(maxsplit=2)[1]


def rounded(text: str) -> str:
    """Libraries and compilers differ in the last digits; of what is round-off the size stays."""

    def shorter(number: re.Match[str]) -> str:
        x = float(number[0])
        return f"{x:.4g}" if abs(x) > 1e-9 else f"{x:.0e}"

    return re.sub(r"-?\d+\.\d+(e[+-]?\d+)?|\d+e[+-]?\d+", shorter, text)


def line(name: str) -> str:
    case = CASES[name]
    command = f"{model_name(case)} {case.arguments}"
    command += " --ensemble ..." if case.members else ""
    said = rounded(outcome(name).said).replace("|", "\\|")
    return f"| {name} | {case.what} | `{command}` | {case.status or '(of a member)'} | {said} |\n"


@pytest.mark.parametrize("name", CASES)
def test_ends_by_its_status(name: str) -> None:
    case, found = CASES[name], outcome(name)
    report, rows = found.report, found.rows
    assert found.code == 4
    if case.members:
        assert report["failed"] == 1 and report["done"] == 1
        assert report["first_failed"]["status"] == "PK_SINGULAR_TIME"
        assert [row[0] for row in rows] == ["1"] * 4 + ["2"] * 3  # up to t = 1 of 1.11
    else:
        assert report["status"] == case.status
        assert not rows or float(rows[-1][0]) <= report["t"]
        if case.status != "PK_DONE":
            assert all(float(x) - float(x) == 0 for row in rows for x in row)
            assert f"{report['t']:.4g}" in rounded(found.said) or report["t"] == 0
        if report["t"] > 0 and case.status != "PK_DONE":
            assert len(rows) > 1
    assert UPDATE or line(name) in PAGE.read_text(encoding="utf-8"), found.said


def test_the_page_has_every_case() -> None:
    """Two tables stand in it, of runs and of programs of one's own."""
    in_c = ""
    for status, (file, test) in IN_C.items():
        text = (ROOT / file).read_text(encoding="utf-8")
        body = text[text.index(f'TEST("{test}")') :]
        assert status in body[: body.index("\nTEST(")]
        in_c += f"| {status} | `{test}` in {file} |\n"
    page = PAGE.read_text(encoding="utf-8")
    head, cases, foot = re.split(
        r"(?<=\|---\|---\|---\|---\|---\|\n)((?:\|.*\n)*)", page, maxsplit=1
    )
    if UPDATE:
        cases = "".join(map(line, CASES))
        PAGE.write_text(head + cases + foot[: foot.index("| PK_")] + in_c, encoding="utf-8")
    assert re.findall(r"^\| ([a-z-]+) \| ", cases, re.MULTILINE) == [*CASES]
    assert foot.endswith("|---|---|\n" + in_c)


def test_no_status_is_without_a_case() -> None:
    text = (ROOT / "runtime/include/pk/status.h").read_text(encoding="utf-8")
    failed = set(re.findall(r"X\((PK_\w+), -\d+,", text))
    shown = {case.status for case in CASES.values()} | set(IN_C)
    assert len(failed) > 10 and failed - shown == {"PK_NO_MEMORY"}
