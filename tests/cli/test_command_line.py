"""The command line by the conventions of command lines: one table, help with examples, what is
meant by a misspelt word, standard streams, loudness, colours, closed pipes."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT, ran, run_pkgen
from pkgen.cli.commands import OVERVIEW_WIDTH, OWN, commands, overview, parser_of
from pkgen.cli.compile import _depends
from pkgen.cli.manual import _plain

HOOP = ROOT / "models/bead_on_hoop.lag"
WRONG = "model wrong\ncoord x\nkinetic x'^2/2 + yy\n"
PLAIN = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "FORCE_COLOR")}

COMMANDS = commands()


def piped(*words: object, text: str = "", env: dict[str, str] = PLAIN, cwd: Path | None = None):
    command = [sys.executable, "-m", "pkgen", *map(str, words)]
    return subprocess.run(command, input=text, capture_output=True, text=True, env=env, cwd=cwd)


def examples(name: str) -> list[str]:
    return COMMANDS[name].module.EXAMPLES.strip().split("\n")


def test_every_file_of_a_command_has_a_row() -> None:
    folder = ROOT / "generator/pkgen/cli"
    with_run = {
        p.stem for p in folder.glob("*.py") if re.search(r"^EXAMPLES = ", p.read_text(), re.M)
    }
    assert with_run == set(OWN) and len(OWN) > 9


@pytest.mark.needs_addon
def test_the_overview_fits_a_terminal() -> None:
    lines = overview().split("\n")
    assert max(map(len, lines)) <= OVERVIEW_WIDTH and len(lines) <= 48
    assert {line.split()[0] for line in lines if line.startswith("  ") and line[2] != " "} == set(
        COMMANDS
    )


@pytest.mark.needs_addon
@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_examples_that_its_parser_takes(name: str) -> None:
    text = parser_of(name).format_help()
    assert text.startswith(f"usage: pkgen {name}") and "-q, --quiet" in text
    for example in examples(name):
        assert f"\n  {example}\n" in text
        words = shlex.split(re.split(" [<>|] ", example)[0])[1:]
        of, words = (words[0], words[1:]) if words[0] in COMMANDS else (name, words)
        assert parser_of(of).parse_intermixed_args(words).quiet is False


@pytest.mark.needs_addon
def test_help_of_a_command_and_of_all() -> None:
    done = run_pkgen("help", "run")
    assert done.returncode == 0 and done.stdout == parser_of("run").format_help()
    assert run_pkgen("run", "--help").stdout == done.stdout
    assert run_pkgen("help").stdout == run_pkgen("--help").stdout == overview() + "\n"
    assert set(json.loads(run_pkgen("help", "--json").stdout)) == set(COMMANDS)


RUN = ("check", "fmt", "help", "explain", "describe", "compile", "run", "methods", "build", "show")
RUN += ("film", "plot")  # the others take minutes
FLIPS = ("models/double_pendulum.lag", "--plan", "models/flips_grid.toml", "-o", "flips")


@pytest.mark.needs_addon
@pytest.mark.parametrize("name", [name for name in RUN if name in COMMANDS])
def test_examples_run(name: str, tmp_path: Path) -> None:
    shutil.copytree(ROOT / "models", tmp_path / "models")
    if name in ("show", "plot"):  # a sweep that has been made
        if "sweep" not in COMMANDS:
            pytest.skip("there are no sweeps here")
        plan = tmp_path / "models/flips_grid.toml"
        plan.write_text(plan.read_text().replace("240", "6"))
        ran("sweep", *FLIPS, cwd=tmp_path)
    for example in examples(name):
        command, _, given = example.partition(" < ")
        words = shlex.split(command)[1:]
        text = (tmp_path / given).read_text() if given else ""
        run = piped(*words, text=text, cwd=tmp_path) if given else run_pkgen(*words, cwd=tmp_path)
        code = 1 if "--check" in words and "not in its layout" in run.stderr else 0
        assert run.returncode == code, f"{example}\n{run.stderr}"


def test_common_options_may_stand_before_the_command() -> None:
    done = run_pkgen("--json", "-q", "check", HOOP)
    assert done.returncode == 0 and json.loads(done.stdout) == {"diagnostics": []}


def test_the_version() -> None:
    assert run_pkgen("-V").stdout == run_pkgen("--version").stdout
    assert re.fullmatch(r"pkgen \d+\.\d+\.\d+\S*\n", run_pkgen("-V").stdout)


def test_a_model_from_standard_input() -> None:
    text = HOOP.read_text()
    done = piped("run", "-", "--until", "1", "--every", "1", text=text)
    assert done.stdout == run_pkgen("run", HOOP, "--until", "1", "--every", "1").stdout
    done = piped("check", "-", text=WRONG)
    assert done.returncode == 1 and done.stderr.startswith("<stdin>:3:18: error: unknown name 'yy'")
    assert piped("check", "-").stderr.startswith("<stdin>:1:1: error: the file is empty")
    done = piped("check", "-", text="\0")
    assert done.returncode == 1 and "NUL" in done.stderr


def test_c_on_standard_output_compiles_as_it_is(tmp_path: Path) -> None:
    done = run_pkgen(HOOP, "-o", "-", cwd=tmp_path)
    assert done.returncode == 0 and list(tmp_path.iterdir()) == []
    words = ["gcc", "-std=c99", "-Wall", "-Werror", "-x", "c", "-c", "-", "-o", "hoop.o"]
    subprocess.run(words, input=done.stdout, text=True, check=True, cwd=tmp_path)


def test_a_picture_on_standard_output(tmp_path: Path) -> None:
    done = run_pkgen("plot", HOOP, "--until", "1", "-o", "-", cwd=tmp_path)
    assert done.returncode == 0 and done.stdout.startswith("<?xml") and "</svg>" in done.stdout


@pytest.mark.needs_addon("pages")
def test_equations_on_standard_output(tmp_path: Path) -> None:
    done = run_pkgen("explain", HOOP, "--html", "-", cwd=tmp_path)
    assert done.stdout.lower().startswith("<!doctype html") and list(tmp_path.iterdir()) == []


def test_quiet_is_quiet_where_all_is_well(write) -> None:
    loud, quiet = (run_pkgen("run", HOOP, "--until", "1", *more) for more in ([], ["-q"]))
    assert loud.stdout == quiet.stdout and "steps" in loud.stderr and quiet.stderr == ""
    scene = "scene b\nuntil 1\nrecord x\nexpect x = 1 within 0.1\nend\n"
    missed = f"model a\ncoord x\nkinetic x'^2/2\n{scene}"
    done = run_pkgen("run", write(missed), "--scene", "b", "-q")
    assert done.returncode == 4 and "expected" in done.stderr
    assert run_pkgen("check", write(WRONG), "-q").stderr.count("unknown name") == 1


def test_verbose_says_what_is_done(tmp_path: Path) -> None:
    done = run_pkgen(HOOP, "-v", "-o", tmp_path)
    said = re.findall(r"^pkgen: +\d+\.\d{3} s  (.*)$", done.stderr, re.M)
    assert said[:3] == ["parse", "check", "derive"] and f"wrote {tmp_path}/bead_on_hoop.h" in said
    assert run_pkgen(HOOP, "-o", tmp_path).stderr == ""


@pytest.mark.parametrize(
    ("env", "coloured"),
    [
        ({}, False),
        ({"FORCE_COLOR": "1"}, True),
        ({"FORCE_COLOR": ""}, False),
        ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, False),
    ],
)
def test_colours(env: dict[str, str], coloured: bool) -> None:
    done = piped("check", "-", text=WRONG, env=PLAIN | env)
    assert ("\x1b[1;31merror\x1b[0m" in done.stderr) == coloured
    plain = re.sub(r"\x1b\[[0-9;]*m", "", done.stderr)
    assert plain == piped("check", "-", text=WRONG).stderr


@pytest.mark.parametrize("words", [["help"], ["describe", HOOP, "--json"], [HOOP, "-o", "-"]])
def test_who_reads_and_goes_away_is_no_error(words: list) -> None:
    command = shlex.join([sys.executable, "-m", "pkgen", *map(str, words)])
    script = f"{command} | true; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("0\n", "")


def test_a_line_that_begins_with_a_dot_is_no_request_of_roff() -> None:
    assert _plain("a\n.TH x\n'so -b") == "a\n\\&.TH x\n\\&'so \\-b"


def test_names_in_a_rule_of_make_are_what_make_reads() -> None:
    assert _depends([Path("a$b #c d.c")]).startswith("a$$b\\ \\#c\\ d.c:")


def test_a_model_is_found_by_its_name(pkgen, tmp_path) -> None:
    """`pkgen check heavy_top` in a clone; a file of that very name comes first."""
    assert pkgen("check", "heavy_top", cwd=ROOT).returncode == 0
    assert pkgen("run", "kepler", "--until", "0.1", "--every", "0.1", cwd=ROOT).returncode == 0
    (tmp_path / "kepler").write_text("model m\n")
    assert "no coordinates" in pkgen("check", "kepler", cwd=tmp_path).stderr


@pytest.mark.skipif(shutil.which("script") is None, reason="no `script` here")
def test_a_terminal_gets_ten_rows_and_a_pipe_all(pkgen, tmp_path) -> None:
    words = [sys.executable, "-m", "pkgen", "run", ROOT / "models/heavy_top.lag", "--until", "1"]
    command = shlex.join(map(str, [*words, "--every", "0.01"]))
    done = subprocess.run(["script", "-qec", command, "/dev/null"], capture_output=True, text=True)
    lines = [line.split() for line in done.stdout.splitlines()]
    rows = [line for line in lines if len(line) == 8 and line[0] != "t"]
    assert [row[0] for row in rows[:2]] == ["0", "0.01"] and rows[5] == ["…"] * 8
    assert len(rows) == 11 and "(101 rows: -o rows.csv keeps them" in done.stdout
    assert len(pkgen(*words[3:], "--every", "0.01").stdout.splitlines()) == 102
