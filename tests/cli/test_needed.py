"""What is emitted for a scene is what its run calls, and its parameters are what it reads.

The oracle is gcov: of the C of a scene, linked with the driver and run, the functions that were
executed. Where M is definite nothing may be there that was not; else the mass matrix, which says
where it is singular when a run ends there.
"""

from __future__ import annotations

import gzip
import json
import pickle
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from conftest import ROOT
from pkgen import __main__ as command
from pkgen.back.kernels import KERNELS
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.run.build import _choice, runtime_library, runtime_links
from pkgen.scenes import compile_plan as scene_use
from pkgen.scenes import lengths, scene
from pkgen.scenes import run as scene_run
from pkgen.scenes import run_settings as parsing
from pkgen.system.toolchain import RUNTIME, find_toolchain

MODELS = sorted((ROOT / "models").rglob("*.lag"))
SCENES = [
    (path.relative_to(ROOT).as_posix(), name)
    for path in MODELS
    for name in re.findall(r"^scene (\w+)", path.read_text(), re.M)
]
LANES = {"lanes", "members", "advance"}
# A process of its own: counts are written where one ends.
RUN = """
import pathlib, pickle
from pkgen.run.library import load
settings, members = pickle.loads(pathlib.Path("asked").read_bytes())
done = load(pathlib.Path("p").absolute()).run(settings, ensemble=members, threads=1)
assert done.code == 0, done.messages
"""


def executed(path: Path, name: str, folder: Path) -> tuple[set[str], set[str], bool]:
    """The kernels that there are in C, those that were executed, and whether M is definite."""
    options = command.parser_of("run").parse_args([str(path), "--scene", name])
    swarm = scene_run.is_swarm(options)
    unroll, use = None if swarm else lengths.UNROLL, scene_use.of_run(options)
    made = compile_model(read(str(path)), unroll=unroll, use=use)
    chosen = scene.chosen(made.declared, name)
    count = scene_run.count(made.declared, chosen) if swarm else None
    settings = parsing.settings(options, made, count, chosen)
    settings = replace(settings, watched=scene_run.watched(made, chosen, settings, swarm))
    if settings.accuracy is not None:
        settings = replace(settings, method="gauss")
    members = None
    if swarm:
        settings = replace(settings, watch=scene_run.watch(made, chosen, settings))
        members = scene_run.members(options, made, chosen, settings)
    tools = find_toolchain()
    library = runtime_library(tools)
    for file, text in made.files.items():
        (folder / file).write_text(text)
    parts = [(part.name, part.coordinates) for part in made.parts]
    (folder / "choice.c").write_text(_choice("pk_model", made.model.name, parts, gsl=tools.has_gsl))
    sources = [file for file in made.files if file.endswith(".c")]
    linked = ["-Wl,--whole-archive", str(library / "librun.a"), "-Wl,--no-whole-archive"]
    linked += runtime_links(tools, library)
    flags = ["-std=c11", "-O0", "--coverage", "-DPK_RUNTIME", f"-I{RUNTIME}/include", "-I."]
    build = ["gcc", *flags, "-fPIC", "-shared", *sources, "choice.c", "-o", "p", *linked]
    subprocess.run(build, cwd=folder, check=True)
    (folder / "asked").write_bytes(pickle.dumps((settings, members)))
    subprocess.run([sys.executable, "-c", RUN], cwd=folder, check=True, capture_output=True)
    there: set[str] = set()
    called: set[str] = set()
    for file in sources:
        stem = file.removesuffix(".c")
        subprocess.run(
            ["gcov", "-j", f"p-{stem}.gcda"], cwd=folder, check=True, capture_output=True
        )
        (report,) = folder.glob("*.gcov.json.gz")
        for found in json.loads(gzip.decompress(report.read_bytes()))["files"]:
            for function in found["functions"] if found["file"].endswith(file) else ():
                kernel = function["name"].removeprefix(f"{stem}_")
                if kernel in KERNELS.keys() | LANES:
                    there.add(kernel)
                    called |= {kernel} if function["execution_count"] else set()
        report.unlink()
    return there, called, getattr(made.structure, "definite", True)


@pytest.mark.parametrize("of", SCENES, ids="-".join)
def test_a_run_calls_all_that_is_there(of, tmp_path):
    path, name = of
    there, called, definite = executed(ROOT / path, name, tmp_path)
    # The acceleration, which a system must have, is not called where M and p are solved for. The
    # kernels of a motion without contacts are not called where one is closed throughout.
    unused = {kernel for kernel in there if kernel.endswith("_free")}
    assert there - called <= {"acceleration"} | unused | (set() if definite else {"mass"})
    assert "acceleration" in there and called


def emitted(path: str, name: str, folder: Path) -> set[str]:
    assert command.main([str(ROOT / path), "--runtime", "--scene", name, "-o", str(folder)]) == 0
    found: set[str] = set()
    for header in folder.glob("*.h"):
        stem = header.stem
        found |= set(re.findall(rf"^\w[\w ]* {stem}_(\w+)\(", header.read_text(), re.M))
    return found & (KERNELS.keys() | LANES)


@pytest.mark.parametrize(
    ("path", "name", "lanes"),
    [
        ("models/coupled_oscillators.lag", "slowest", set()),
        ("models/bead_on_hoop.lag", "balanced", set()),
        ("models/bead_on_hoop.lag", "pendulums", {"members"}),
        ("models/double_pendulum.lag", "slow", set()),
        ("models/double_pendulum.lag", "reference", {"lanes"}),
        ("models/chains/fput.lag", "harmonic", {"advance"}),
        ("models/chains/peierls_nabarro.lag", "valley", set()),
    ],
)
def test_lanes_are_for_methods_that_call_them(path, name, lanes, tmp_path):
    found = emitted(path, name, tmp_path)
    assert found & LANES == lanes
    assert not found & {"gradient", "momenta", "lagrangian", "kinetic", "potential"}


RATTLEBACK = ROOT / "models/constrained/rattleback.lag"


def test_a_scene_has_the_parameters_that_it_reads(pkgen, tmp_path):
    assert pkgen(RATTLEBACK, "--scene", "reverses", "-o", tmp_path).returncode == 0
    text = (tmp_path / "rattleback_reverses.h").read_text()
    text, _, _ = text.partition("/* Computed by")
    fields = re.findall(r"    pk_real (\w+);", text[text.index("reverses_params {") :])
    assert " ".join(fields) == "m a b c h A B C D g n2 nx ny nz rx ry rz"
    assert "d, rho_x, rho_y, det, half, apart, growth, pitching, steep: nothing" in text
