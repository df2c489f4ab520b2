"""MEX, compiled by Octave: the example of its page, what it refuses, events, rotations."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from conftest import ROOT, run_pkgen

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(
        not (shutil.which("mkoctfile") and shutil.which("octave-cli")),
        reason="no octave and octave-dev here",
    ),
]
PAGE = (ROOT / "addons/hosts/export-matlab.md").read_text()
REFUSED = """
function says(varargin)
    try, double_pendulum(0:1, varargin{:}); disp('nothing');
    catch e, disp(e.message); end
end
says('m1', -1); says('nobody', 1); says('m1'); says('method', 'verlet', 'step', 0.1);
says('theta1', 'x'); says('rtol', 0); says('rtol', nan);
try, double_pendulum([0 1 0.5]); catch e, disp(e.message); end
try, double_pendulum([0 inf]); catch e, disp(e.message); end
"""


def octave(script: str, folder: Path) -> list[str]:
    (folder / "script.m").write_text("1;\n" + script)
    done = subprocess.run(
        ["octave-cli", "--quiet", "--no-gui", "script.m"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    # Octave 7 says that of every script.
    said = done.stderr.replace(
        "error: ignoring const execution_exception& while preparing to exit", ""
    )
    assert not said.strip(), said
    return done.stdout.splitlines()


def export(model: str, to: Path, *words: str) -> None:
    done = run_pkgen("export", ROOT / "models" / model, "--as", "matlab", "-o", to, *words)
    assert done.returncode == 0, done.stderr


def block(language: str) -> str:
    return re.search(rf"^```{language}\n(.*?)^```", PAGE, re.M | re.S)[1]


def test_the_example_of_the_page(tmp_path: Path) -> None:
    export("double_pendulum.lag", tmp_path / "pendulum")
    *shown, a, b, c, d, e, f, g, h, i = octave(
        REFUSED.replace("says('m1', -1)", block("matlab") + "says('m1', -1)"), tmp_path
    )
    assert "\n".join(shown) + "\n" == block("text")
    assert "m1 is outside its bounds" in a and "there is no 'nobody'" in b and "pairs" in c
    assert "verlet needs" in d and "theta1: a real number" in e
    assert "rtol must be positive" in f and f == g
    assert "t = 0.5 is before its last step" in h and "is not finite" in i
    words = ("--set", "l2=0.5", "--method", "dop853", "--rtol", "1e-12", "--until", "1")
    run = run_pkgen("run", ROOT / "models/double_pendulum.lag", *words, "--every", "1")
    exact = [float(x) for x in run.stdout.splitlines()[-1].split(",")]
    assert [float(x) for x in shown[0].split()] == pytest.approx([*exact[1:3], exact[-1]], abs=2e-9)


def test_events_and_rotations(tmp_path: Path) -> None:
    export("particles/thrown_stone.lag", tmp_path)
    script = """build(); [t, y, more] = thrown_stone(0:0.1:100);
    printf('%d %s\\n', more.stopped, strjoin(more.events(more.crossings(:, 1)), ' '));
    printf('%.9f %.9f\\n', t(end), y(end, strcmp(more.names, 'y')));
    printf('%.12g ', t(end - 1), y(end - 1, :));"""
    first, second, before = octave(script, tmp_path)
    assert first == "1 apex ground"
    assert abs(float(second.split()[1])) < 1e-9 < float(second.split()[0])
    t, *row = map(float, before.split())  # in the step that the event ended
    words = ("--every", "0.1", "--until", "9", "--rtol", "1e-13")
    run = run_pkgen("run", ROOT / "models/particles/thrown_stone.lag", *words)
    rows = [[float(x) for x in line.split(",")] for line in run.stdout.splitlines()[1:]]
    (exact,) = [r for r in rows if abs(r[0] - t) < 1e-9]
    assert row == pytest.approx(exact[1 : 1 + len(row)], abs=2e-9)  # of 60 m, at rtol 1e-10
    export("bodies/free_body.lag", tmp_path)
    script = """build(); [t, y, more] = free_body([0 1 5]); printf('%.12f ', y(end, :));
    printf('\\n%s', strjoin(more.names));"""
    said, names = octave(script, tmp_path)
    run = run_pkgen("run", ROOT / "models/bodies/free_body.lag", "--until", "5", "--every", "5")
    head, *_, last = run.stdout.splitlines()
    exact = dict(zip(head.split(","), map(float, last.split(",")), strict=True))
    for name, value in zip(names.split(), said.split(), strict=True):
        assert float(value) == pytest.approx(exact[name], abs=1e-9)
