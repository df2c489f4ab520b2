"""An add-on of somebody else's, and one that is named but not here."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT

MODEL = ROOT / "models/double_pendulum.lag"
POINTS = """[pkgen.commands]
count = pkgen_toy.count
gone = pkgen_gone.command

[pkgen.exports]
toy = pkgen_toy.host:TOY
gone = pkgen_gone.host:GONE

[pkgen.options]
run.twice = pkgen_toy.twice

[pkgen.folders]
gone = pkgen_gone.folder
"""
FILES = {
    "__init__.py": '''"""Counts coordinates."""

COMMANDS = """
Look at a model
  count       MODEL.lag                    how many coordinates it has
"""
''',
    "count.py": '''from pkgen.cli.compilation import compile_within_limits

EXAMPLES = "pkgen count models/double_pendulum.lag"


def arguments(parser):
    pass


def run(options):
    """Count the coordinates of a model."""
    print(len(compile_within_limits(options).model.coordinates))
    return 0
''',
    "host.py": """from pkgen.back.exported import Host


def make(model):
    return {"names.txt": "\\n".join(q["name"] for q in model.description["coordinates"]).encode()}


TOY = Host("toy", "the names of its coordinates", make, ".txt")
""",
    "twice.py": """def arguments(parser):
    parser.add_argument("--twice", dest="instead", action="store_const", const=run, help="2")


def run(options):
    print(options.model, options.model)
    return 0
""",
}


@pytest.fixture(scope="module")
def toy(tmp_path_factory: pytest.TempPathFactory):
    """Runs pkgen with the add-on on its path."""
    folder = tmp_path_factory.mktemp("toy")
    info = folder / "pkgen_toy-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: pkgen-toy\nVersion: 1\n")
    (info / "entry_points.txt").write_text(POINTS)
    (folder / "pkgen_toy").mkdir()
    for name, text in FILES.items():
        (folder / "pkgen_toy" / name).write_text(text)

    def run(*words: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        path = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
        command = [sys.executable, "-m", "pkgen", *map(str, words)]
        env = os.environ | {"PYTHONPATH": path}
        return subprocess.run(command, capture_output=True, text=True, env=env, cwd=cwd)

    return run


def test_its_command_is_one(toy) -> None:
    assert toy("count", MODEL).stdout == "2\n"
    assert "\n  count      how many coordinates it has\n" in toy("help").stdout
    assert toy("count", "--help").stdout.startswith("usage: pkgen count MODEL.lag")
    assert "did you mean 'count'?" in toy("coumt", MODEL).stderr


def test_its_host_is_one(toy, tmp_path: Path) -> None:
    assert "\n  toy          the names of its coordinates\n" in toy("export", "--help").stdout
    assert toy("export", MODEL, "--as", "toy", cwd=tmp_path).returncode == 0
    assert (tmp_path / "names.txt").read_text() == "theta1\ntheta2"


def test_its_option_is_one(toy) -> None:
    assert toy("run", MODEL, "--twice").stdout == f"{MODEL} {MODEL}\n"
    assert "--twice" in toy("run", "--help").stdout


@pytest.mark.parametrize("words", [("gone", "x.lag"), ("export", MODEL, "--as", "gone")])
def test_what_is_not_here_is_said_in_a_line(toy, words: tuple[object, ...]) -> None:
    done = toy(*words)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "pkgen: gone is of the add-on gone, which is not here: install all of pkgen-toy\n"
    )


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory):
    """Runs pkgen where its own add-ons are named and not here."""
    folder = tmp_path_factory.mktemp("alone")
    for name in ("pkgen", "pkgen_runtime"):
        (folder / name).symlink_to(ROOT / "generator" / name)
    info = folder / "pkgen_lag-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: pkgen-lag\nVersion: 1\n")
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    groups = re.findall(r'^\[project.entry-points."(.*)"\]\n((?:.+\n)*)', text, re.M)
    points = "".join(f"[{group}]\n{lines}\n" for group, lines in groups)
    (info / "entry_points.txt").write_text(points.replace('"', ""))
    packages = [p for p in sys.path if Path(p).name in ("site-packages", "dist-packages")]
    path = os.pathsep.join([str(folder), *packages])

    def run(*words: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-S", "-m", "pkgen", *map(str, words)]
        env = os.environ | {"PYTHONPATH": path}
        return subprocess.run(command, capture_output=True, text=True, env=env, cwd=folder)

    return run


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("explain", MODEL, "--html", "x.html"), "explain --html is of the add-on pages"),
        (("run", MODEL, "--report", "x.html"), "run --report is of the add-on pages"),
        (("run", MODEL, "--enclose"), "run --enclose is of the add-on enclose"),
        (("chart", MODEL, "--against", "gsl"), "chart --against is of the add-on peers"),
        (("show", MODEL), "show is of the add-on web"),
        (("export", MODEL, "--as", "fmu"), "fmu is of the add-on fmu"),
    ],
)
def test_an_option_of_ours_that_is_not_here_is_said_in_a_line(alone, words, said) -> None:
    done = alone(*words)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert done.stderr == f"pkgen: {said}, which is not here: install all of pkgen-lag\n"
