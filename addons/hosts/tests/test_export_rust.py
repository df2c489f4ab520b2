"""The crate: its doctest, the example of its page, what it refuses, two models in one program."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from conftest import ROOT, run_pkgen

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not shutil.which("cargo"), reason="no cargo here"),
]
PAGE = (ROOT / "addons/hosts/export-rust.md").read_text()
MANIFEST = """[package]
name = "user"
version = "0.1.0"
edition = "2021"
[dependencies]
double_pendulum = { path = "../double_pendulum" }
thrown_stone = { path = "../thrown_stone" }
"""
USES = (ROOT / "addons/hosts/tests/export_user.rs").read_text()


def export(model: Path, to: Path, *words: str) -> None:
    done = run_pkgen("export", model, "--as", "rust", "-o", to, *words)
    assert done.returncode == 0, done.stderr


def cargo(*words: str, cwd: Path, target: Path) -> str:
    env = {**os.environ, "CARGO_TARGET_DIR": str(target)}
    done = subprocess.run(
        ["cargo", *words], cwd=cwd, env=env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr[-3000:]
    assert "warning" not in done.stderr
    return done.stdout


def test_the_crate(tmp_path: Path) -> None:
    target = tmp_path / "target"
    export(ROOT / "models/double_pendulum.lag", tmp_path / "double_pendulum")
    export(ROOT / "models/particles/thrown_stone.lag", tmp_path / "thrown_stone")
    for name in ("double_pendulum", "thrown_stone"):
        said = cargo("test", cwd=tmp_path / name, target=target)
        assert "1 passed" in said  # the example of its documentation
    (main,) = re.findall(r"^```rust\n(.*?)^```", PAGE, re.M | re.S)
    (shown,) = re.findall(r"^```text\n(.*?)^```", PAGE, re.M | re.S)
    user = tmp_path / "user"
    (user / "src").mkdir(parents=True)
    (user / "Cargo.toml").write_text(MANIFEST)
    (user / "src/main.rs").write_text(main + USES)
    assert cargo("run", "-q", cwd=user, target=target) == shown
    assert "4 passed" in cargo("test", cwd=user, target=target)
    words = ("--set", "l2=0.5", "--method", "dop853", "--rtol", "1e-12", "--until", "1")
    run = run_pkgen("run", ROOT / "models/double_pendulum.lag", *words, "--every", "1")
    exact = [float(x) for x in run.stdout.splitlines()[-1].split(",")]
    found = [float(x) for x in re.findall(r" (-?\d+\.\d{9})", shown)]
    assert found == pytest.approx([*exact[1:3], exact[-1]], abs=2e-9)


ODD = """model odd               # names that are words of Rust, families, followers
param type = 1 [kg] in (0, inf)
param k[i = 1..3] = 2 [N/m]
param half = type/2
coord x [m]
kinetic type/2*x'^2
potential sum(k[i], i = 1..3)/2*x^2
start x = 0.5
state loop [kg]
rate loop = -(loop - half)/(1 [s])
start loop = 3
"""


def test_rotations_states_and_words_of_the_language(tmp_path: Path) -> None:
    (tmp_path / "odd.lag").write_text(ODD)
    for model in (ROOT / "models/bodies/free_body.lag", tmp_path / "odd.lag"):
        export(model, tmp_path / model.stem)
        cargo("test", cwd=tmp_path / model.stem, target=tmp_path / "target")
    source = (tmp_path / "odd/src/lib.rs").read_text()
    for line in ("pub type_: f64,", "pub k: [f64; 3],", "half: f64::NAN,", 'of("loop", "kg", "")'):
        assert line in source
