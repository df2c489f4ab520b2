"""Every scene of every model runs, and what it expects is met; and would be missed by worse.

`make test` runs all scenes of the models in models/ itself, and the first ones of IN_TEST in its
folders: a second a scene goes to the C compiler. `make test-long` and `python -m bench systems` run
all of them.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from conftest import ROOT, ran, written

MODELS = sorted((ROOT / "models").rglob("*.lag"))
IN_TEST = {"thrown_stone", "kepler", "henon_heiles", "n_body", "pendulum", "foucault"}
IN_TEST |= {"beats", "fput", "sine_gordon", "free_body", "pendulum_rod", "rattleback"}
# What makes each scene's expectations fail: a worse tolerance or step, another start. By default
# the former; the text of the C stays the same.
WORSE = {
    "bead_on_hoop balanced": ["--start", "theta=1.17"],
    "bead_on_hoop pendulums": ["--step", "0.2"],
    "beats against": ["--start", "x1=1.01"],
    "beats beat": ["--start", "x1=1.01"],
    "beats in_phase": ["--start", "x1=1.01"],
    "coupled_oscillators reference": ["--start", "q[1]=0.71"],
    "coupled_oscillators slowest": ["--start", "q[1]=0.7"],
    "double_pendulum fast": ["--start", "theta1=1.001e-4"],
    "double_pendulum slow": ["--start", "theta1=1.001e-4"],
    "double_pendulum_rods hangs": ["--start", "x1'=0.1"],
    "elastic_cartesian bounce": ["--start", "y=-2.6"],
    "elastic_cartesian exchange": ["--set", "k=4.2"],
    "elastic_cartesian stiff": ["--step", "0.02002", "--every", "0.02002"],
    "foucault cusps": ["--start", "x=3.001"],
    "foucault equator": ["--start", "x=3.001"],
    "foucault fast_planet": ["--start", "x=0.1001"],
    "foucault rosette": ["--start", "x=3.001"],
    "fput harmonic": ["--step", "0.5"],
    "fput long": ["--step", "0.2"],
    "fput recurrence": ["--start", "q[1]=0.1"],
    "fput_beta first_mode": ["--method", "rk4", "--step", "0.5"],
    "fput_beta four_springs": ["--start", "q[2]=0.01"],
    "hanging swings": ["--start", "theta[20]=2e-7"],
    "gyroscope fast": ["--start", "theta=0.9"],
    "gyroscope slow": ["--start", "theta=0.9"],
    "harmonic_fixed fastest": ["--start", "q[2]=0.01"],
    "harmonic_fixed mode": ["--start", "q[1]=0.5"],
    "harmonic_free mode": ["--start", "q[1]=0.5"],
    "harmonic_free splitting": ["--start", "q[1]=0.5"],
    "harmonic_ring splitting": ["--start", "q[1]=0.5"],
    "harmonic_ring wave": ["--start", "q[1]=0.5"],
    "heavy_top precession": ["--start", "theta=1.05"],
    "heavy_top_rotation loops": ["--set", "precession=0.4"],
    "henon_heiles chaos": ["--start", "x=1.2"],
    "henon_heiles sections": ["--set", "E=0.1", "--rtol", "1e-2"],
    "kepler eccentric": ["--step", "1e-3"],
    "kepler turned": ["--step", "0.0034"],
    "lengthening_pendulum fast": ["--set", "speed=0.01"],
    "peierls_nabarro finer": ["--set", "c=0.05"],
    "peierls_nabarro pass": ["--set", "x0=0.4"],
    "peierls_nabarro trapped": ["--start", "q[20]=3.2"],
    "peierls_nabarro valley": ["--set", "c=0.05"],
    "pendulum all_amplitudes": ["--step", "0.2"],
    "pendulum loop": ["--step", "1"],
    "restricted_three_body L1": ["--start", "x=0.8362927"],
    "restricted_three_body L4_below": ["--set", "mu=0.05"],
    "restricted_three_body leaves_L1": ["--start", "x'=0"],
    "pendulum over_the_top": ["--start", "theta'=9.4"],
    "pendulum_action drawn_up": ["--start", "theta=1.5"],
    "pendulum_action slow": ["--rtol", "1e-3"],
    "pendulum_rod over_the_top": ["--start", "x'=9.4"],
    "projectile flat": ["--start", "x'=35"],
    "projectile steep": ["--start", "x'=35"],
    "projectile thrown": ["--start", "x'=35"],
    "projectile vacuum": ["--start", "x'=35"],
    "rattleback_reduced achiral": ["--method", "rk4"],
    "rattleback_reduced both_senses": ["--set", "p0=0.011"],
    "rattleback_reduced fed_by_spin": ["--set", "p0=1e-4"],
    "rattleback_reduced friction": ["--set", "p0=0.011"],
    "rattleback_reduced friction_other_sense": ["--method", "rk4", "--step", "0.2"],
    "rattleback_reduced other_sense": ["--set", "p0=0.011"],
    "restricted_three_body L4_above": ["--set", "mu=0.038"],
    "rope gust": ["--set", "c=1"],
    "rope hangs": ["--set", "blow=0.1"],
    "sine_gordon breather": ["--start", "q[200]=3"],
    "sine_gordon collision": ["--start", "q[100]=1"],
    "sine_gordon kink": ["--start", "q[160]=1"],
    "sine_gordon_free reflection": ["--start", "q[100]=1"],
    "sine_gordon_free small": ["--start", "q[100]=1"],
    "thrown_stone moon": ["--start", "y'=49.99"],
    "slider_crank dead_centres": ["--rtol", "1e-7"],
    "space_arm stiff": ["--set", "v=1"],
    "two_links slow": ["--set", "l2=1.1"],
}


def scenes() -> list:
    found = []
    for path in MODELS:
        named = re.findall(r"^scene (\w+)(.*?)^end$", path.read_text(), re.M | re.S)
        for k, (name, body) in enumerate(named):
            long = path.parent != ROOT / "models" and (k > 0 or path.stem not in IN_TEST)
            numbers = [
                3 if "= [" in line else 1 for line in re.findall(r"^  expect .*", body, re.M)
            ]
            found.append(
                pytest.param(
                    *(path, name, sum(numbers)),  # of a vector three
                    id=f"{path.stem}-{name}",
                    marks=[pytest.mark.long] * long,
                )
            )
    return found


SCENES = scenes()


def test_each_model_has_two_scenes_that_expect_something() -> None:
    for path in MODELS:
        assert sum(s.values[0] == path and s.values[2] > 0 for s in SCENES) >= 2, path.name
    names = {f"{s.values[0].stem} {s.values[1]}" for s in SCENES}
    assert set(WORSE) <= names and {path.stem for path in MODELS} >= IN_TEST


@pytest.mark.parametrize(("path", "name", "expected"), SCENES)
def test_a_scene_is_as_expected(tmp_path: Path, path: Path, name: str, expected: int):
    command = ["run", path, "--scene", name, "-o", tmp_path / "rows.csv"]
    done = ran(*command)
    assert (f"expected: {expected} of {expected} met" in done.stderr) == (expected > 0)


@pytest.mark.parametrize(("path", "name", "expected"), SCENES)
def test_a_worse_run_misses(pkgen, tmp_path: Path, path: Path, name: str, expected: int):
    if expected:
        command = ["run", path, "--scene", name, "-o", tmp_path / "rows.csv"]
        worse = pkgen(*command, *WORSE.get(f"{path.stem} {name}", ["--rtol", "1e-4"]))
        assert worse.returncode == 4 and "error: expectation missed: " in worse.stderr, name


def test_a_component_of_a_constraint_is_fulfilled_by_what_is_held(tmp_path):
    path = written(
        tmp_path,
        "model held\ncoord x, y, z, u\nkinetic (x'^2 + y'^2 + z'^2 + u'^2)/2\n"
        "constraint c: [x, y, z] = [u, 2*u, 0]\nstart x' = 1, u' = 1, y' = 2\n"
        "scene still\n hold z = 0\n until 1\n record y every 1\nend\n",
    )
    done = ran("run", path, "--scene", "still")
    assert done.stdout.splitlines()[-1] == "1,2"
