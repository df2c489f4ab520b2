"""`pkgen export`: names, options, places of files; and that what is exported compiles alone."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

from conftest import ROOT, run_pkgen
from pkgen.cli.export import hosts
from pkgen_hosts.bindings.names import step

PENDULUM = ROOT / "models" / "double_pendulum.lag"
MAIN = """#include <stdio.h>
#include "double_pendulum.h"
#include "include/pk/pk.h"
int main(void)
{
    static double block[1 << 16];
    struct double_pendulum_params params;
    double q[2], v[2];
    double_pendulum_system.defaults(&params);
    double_pendulum_system.start(&params, q, v);
    const struct pk_problem problem = {.system = &double_pendulum_system, .params = &params};
    const struct pk_method *method = pk_method_find("gauss");
    const struct pk_options options = pk_options_default();
    struct pk_integrator it;
    pk_integrator_init(&it, &problem, method, &options, 0, q, v, block, sizeof block);
    pk_integrator_to(&it, 1);
    printf("%.17g %.17g\\n", it.q[0], it.q[1]);
    return 0;
}
"""


def test_sources_compile_alone_and_run(tmp_path: Path) -> None:
    done = run_pkgen("export", PENDULUM, "--as", "source", "-o", tmp_path / "p")
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "p"
    (folder / "main.c").write_text(MAIN)
    sources = sorted(map(str, folder.rglob("*.c")))
    subprocess.run(["gcc", "-std=c11", "-O0", *sources, "-o", folder / "main", "-lm"], check=True)
    said = subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout
    run = run_pkgen("run", PENDULUM, "--until", "1", "--every", "1")
    expected = run.stdout.splitlines()[-1].split(",")[1:3]
    assert [float(x) for x in said.split()] == pytest.approx([float(x) for x in expected], abs=1e-9)
    model = json.loads((folder / "model.json").read_text())
    assert model["model"] == "double_pendulum" and model["drawing"] is None
    assert not [o for o in model["outputs"] if o["hidden"]]


def of_fmu(words: tuple[str, ...], said: str):
    return pytest.param(words, said, marks=pytest.mark.needs_addon("fmu"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "--as: name what it is made for"),
        (("--as", "sourse"), "did you mean 'source'?"),
        (("--as", "source", "-o", str(PENDULUM)), "this is a file; give a folder"),
        (("--as", "source", "--scene", "nosuch"), "no such scene"),
        of_fmu(("--as", "fmu", "--method", "verlet"), "method verlet: it is for systems that are"),
        (("--as", "python", "--method", "gsl_rkf45"), "nothing that is exported has GSL"),
        of_fmu(("--as", "python", "--fmi", "2"), "--fmi: this is of --as fmu, not of --as python"),
        of_fmu(("--as", "fmu", "--fmi", "4"), "--fmi: 4: there are: 3, 2"),
        of_fmu(("--as", "fmu", "-o", "unit.zip"), "the file's name must end in .fmu"),
        (
            ("--as", "source", "--metod", "rk4"),
            "there is no option --metod; did you mean '--method'",
        ),
    ],
)
def test_what_is_wrong_is_said(words: tuple[str, ...], said: str, tmp_path: Path) -> None:
    done = run_pkgen("export", PENDULUM, *words, cwd=tmp_path)
    assert done.returncode == 2 and said in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_an_earlier_export_stays_where_the_model_is_wrong(tmp_path: Path) -> None:
    good = run_pkgen("export", PENDULUM, "--as", "source", "-o", "p", cwd=tmp_path)
    assert good.returncode == 0
    (tmp_path / "p" / "mine.c").write_text("int mine;\n")
    before = {path: path.read_bytes() for path in (tmp_path / "p").rglob("*") if path.is_file()}
    bad = tmp_path / "double_pendulum.lag"
    bad.write_text(PENDULUM.read_text() + "\nparam x\n")
    done = run_pkgen("export", bad, "--as", "source", "-o", "p", cwd=tmp_path)
    assert done.returncode == 1
    after = {path: path.read_bytes() for path in (tmp_path / "p").rglob("*") if path.is_file()}
    assert before == after


def test_hosts_that_share_an_option_mean_the_same() -> None:
    said: dict[str, object] = {}
    for host in hosts().values():
        for flag, how in host.options:
            assert said.setdefault(flag, how) == how


@pytest.mark.parametrize("tools", [False, pytest.param(True, marks=pytest.mark.long)])
def test_nothing_that_is_exported_names_gsl(tmp_path: Path, tools: bool) -> None:
    """But in comments."""
    steps = ("--method", "rk4", "--step", "0.01")  # some take no others
    for host in (h for h in hosts().values() if bool(h.tools) == tools):
        done = run_pkgen("export", PENDULUM, "--as", host.name, "-o", tmp_path / host.name, *steps)
        if done.returncode == 3 and host.tools:
            continue  # they are not here
        assert done.returncode == 0, done.stderr
        for path in (tmp_path / host.name).rglob("*.[ch]"):
            assert "gsl" not in re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.S).lower(), path


def test_a_model_called_as_a_file_of_the_export(tmp_path: Path) -> None:
    (tmp_path / "m.lag").write_text(PENDULUM.read_text().replace("double_pendulum", "called", 1))
    done = run_pkgen("export", tmp_path / "m.lag", "--as", "source", cwd=tmp_path)
    assert done.returncode == 2 and "called.h is a file of the export itself" in done.stderr


def _lines(text: str) -> int:
    return sum(1 for line in text.splitlines() if line.strip())


@pytest.mark.needs_addon("fmu")
def test_lines_of_ones_own_are_those_of_the_pages() -> None:
    """The last number of a row that links a page: its first program's."""
    _, _, table = (ROOT / "addons/hosts/README.md").read_text().partition("## Lines of one's own")
    rows = re.findall(r"(\d+)[^\d|]*\[the page\]\((.*?)\)", table)
    assert len(rows) == 5
    for count, page in rows:
        text = (ROOT / "addons/hosts" / page).read_text()
        languages = re.findall(r"^```(?!console|sh|text)\w+\n(.*?)^```", text, re.M | re.S)
        assert int(count) == _lines(languages[0]), page
    assert f"{_lines((ROOT / 'docs/embed.c').read_text())}, [embed.c](../../docs/embed.c)" in table


def test_methods_that_choose_their_step_are_given_none() -> None:
    def first(adaptive: bool, **run: float | None) -> float:
        methods = [{"name": "it", "adaptive": adaptive}, {"name": "x", "adaptive": not adaptive}]
        return step({"run": {"method": "it", "until": 9.0, **run}, "methods": methods})

    assert first(True, step=None, every=0.5) == 0
    assert first(False, step=None, every=0.5) == 0.5
    assert first(False, step=None, every=None) == 0.009
    assert first(True, step=0.25, every=0.5) == first(False, step=0.25, every=0.5) == 0.25
