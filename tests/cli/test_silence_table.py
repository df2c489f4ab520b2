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
    "PK_BAD_ARGUMENT": ("tests/runtime/test_silence.c", "refused_options"),
    "PK_OUT_OF_BOUNDS": ("tests/runtime/test_silence.c", "parameters"),
    "PK_BLOCK_TOO_SMALL": ("tests/runtime/test_status.c", "bad_arguments"),
}
HEAD = """# Never silent

No run passes over any of this: it ends with the status, exit code 4, the last valid time, and rows
up to that time alone (`beyond` is known only at the end of the run: there rows behind the last
valid time, in JSON `last_valid`, are written too, and are void). Each line is provoked by
`tests/cli/test_silence_table.py`, which also writes this page (numbers rounded to four digits); the
cases are in `tests/cli/silence.toml`.

| case | what | run | status | says |
|---|---|---|---|---|
"""
FOOT = """
A step that is too long for its method may leave the motion without a sign of it. So behind the
reason stands, after "last valid time", since when the energy of a conservative system is off by
more than .01 of its scale, and for fixed steps and loose tolerances what dop853 at 1e-9 makes of
the same motion. Fixed steps that *arrive* with such an energy are judged by dop853 too: where the
motion ends on the way (it runs away in finite time) the exit code is 4; likewise where they stop at
an event. Where it does not end, a run that arrives with such an energy, by whatever method, says
so in a warning (`warning` in the report), and its exit code is 0.

Of an ensemble with fixed steps, members of a conservative system whose energy at their last row is
off by more than .01 of its scale are counted in a warning (`astray`, `first_astray`). They are not
followed further: the exit code stays, no member is run by dop853, and an energy that is wrong on
the way and right again at the end is not seen.

What fixed steps cannot tell: that a motion without a constant energy (forces, inputs, explicit
time) has run away in finite time. A large change in one step is no sign: a kick by an input and a
close passage have it too. Such a run is silent until numbers overflow (PK_NOT_FINITE), a few
steps later; then dop853 is asked, and rows behind the end that it tells are void. An adaptive
method tells at once: there steps underflow.

By programs of one's own alone, since `pkgen run` sees to it:

| status | provoked by |
|---|---|
"""


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
    with (
        tempfile.TemporaryDirectory() as scratch,
        redirect_stdout(stdout),
        redirect_stderr(stderr),
    ):
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
    foot = FOOT
    for status, (file, test) in IN_C.items():
        text = (ROOT / file).read_text(encoding="utf-8")
        body = text[text.index(f"static void {test}(") :]
        assert status in body[: body.index("\n}\n")]
        foot += f"| {status} | `{test}` in {file} |\n"
    if UPDATE:
        PAGE.write_text(HEAD + "".join(map(line, CASES)) + foot, encoding="utf-8")
    page = PAGE.read_text(encoding="utf-8")
    named = re.findall(r"^\| ([a-z-]+) \| ", page.removesuffix(foot), re.MULTILINE)
    assert page.startswith(HEAD) and page.endswith(foot)
    assert named == ["case", *CASES]


def test_no_status_is_without_a_case() -> None:
    text = (ROOT / "runtime/include/pk/status.h").read_text(encoding="utf-8")
    failed = set(re.findall(r"X\((PK_\w+), -\d+,", text))
    shown = {case.status for case in CASES.values()} | set(IN_C)
    assert len(failed) > 10 and failed - shown == {"PK_NO_MEMORY"}
