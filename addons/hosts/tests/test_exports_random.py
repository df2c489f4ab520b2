"""Random models, methods, steps, parameters and scenes on each host, against `pkgen run`."""

from __future__ import annotations

import json
import random
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from conftest import ROOT, run_pkgen, table
from pkgen.back.wasm.build import missing
from pkgen.methods import METHODS
from pkgen_hosts.bindings.names import tables

pytestmark = pytest.mark.long
MODELS = sorted((ROOT / "models").rglob("*.lag"))
Rows = dict[str, list[float]]
IN_WHEEL = """import json, {name} as d
rows = d.Model().run({until!r}, every={every!r})
print(json.dumps({{name: rows[name].tolist() for name in rows.columns}}))
"""
IN_NODE = """import {{ load }} from "{made}/index.js";
const motion = (await load()).motion();
const rows = [];
for (let k = 0; k <= {count}; k++) {{
  if (!motion.to(k * {every!r})) break;
  rows.push([motion.t, ...motion.q, ...motion.v]);
}}
console.log(JSON.stringify(rows));
"""
IN_FMPY = """import fmpy, json
rows = fmpy.simulate_fmu("{made}", fmi_type="CoSimulation", stop_time={until!r},
                         output_interval={every!r})
names = {{name: "t" if name == "time" else name for name in rows.dtype.names}}
print("\\n" + json.dumps({{names[name]: rows[name].tolist() for name in names}}))
"""


def said(*command: object, cwd: Path) -> str:
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, cwd=cwd)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def named(text: str) -> Rows:
    head, rows = table(text)
    return dict(zip(head, map(list, zip(*rows, strict=True)), strict=True))


def wheel(made: Path, folder: Path, of: dict, **how: float) -> Rows:
    (path,) = made.glob("*.whl")
    zipfile.ZipFile(path).extractall(folder / "in")
    text = IN_WHEEL.format(name=of["model"], **how)
    return json.loads(said(sys.executable, "-c", text, cwd=folder / "in"))


def node(made: Path, folder: Path, of: dict, **how: float) -> Rows:
    text = IN_NODE.format(made=made, count=round(how["until"] / how["every"]), **how)
    (folder / "main.mjs").write_text(text)
    rows = json.loads(said("node", "main.mjs", cwd=folder))
    found = tables(of)
    names = [q["name"] for kind in ("coordinates", "rates") for q in found[kind]]
    return dict(zip(["t", *names], map(list, zip(*rows, strict=True)), strict=True))


def one_file(made: Path, folder: Path, of: dict, **how: float) -> Rows:
    flags = ["-O2", "-march=native", "-ffp-contract=off", "-fno-math-errno"]
    said("gcc", *flags, made, "-o", "one", "-lm", cwd=folder)
    return named(said("./one", cwd=folder))


def unit(made: Path, folder: Path, of: dict, **how: float) -> Rows:
    (path,) = made.glob("*.fmu")
    text = IN_FMPY.format(made=path, **how)
    return json.loads(said(sys.executable, "-c", text, cwd=folder).splitlines()[-1])


HOSTS = {"python": wheel, "js": node, "single": one_file, "fmu": unit}


def chosen(chance: random.Random, of: dict, host: str, every: float) -> list[str]:
    words = []
    if of["scenes"] and chance.random() < 0.4:
        words += ["--scene", chance.choice(of["scenes"])["name"]]
    for p in of["parameters"]:
        if isinstance(p.get("value"), float) and "length" not in p and chance.random() < 0.25:
            words += ["--set", f"{p['name']}={p['value'] * chance.uniform(0.8, 1.25)!r}"]
    if chance.random() < 0.8 or host == "single":
        methods = [m for m in of["methods"] if m["applies"] and not m["gsl"]]
        if host == "single":
            methods = [m for m in methods if METHODS[m["name"]].family in ("ERK", "SPLITTING")]
        method = chance.choice(methods)
        words += ["--method", method["name"]]
        if not method["adaptive"]:  # rows end steps, as communication points do
            words += ["--step", repr(every / chance.choice([5, 12]))]
    return words


@pytest.mark.parametrize("host", HOSTS)
@pytest.mark.parametrize("seed", range(6))
def test_rows_are_those_of_a_run(seed: int, host: str, tmp_path: Path) -> None:
    if host == "js" and (missing() or not shutil.which("node")):
        pytest.skip("no node, clang or wasi-libc here")
    if host == "fmu":
        pytest.importorskip("fmpy.fmi3")
    chance = random.Random(f"{seed} {host}")
    model = chance.choice(MODELS)
    of = json.loads(run_pkgen("describe", model, "--json").stdout)
    until = chance.choice([0.25, 0.5, 1.0])
    every = until / 8
    words = chosen(chance, of, host, every)
    print(model.stem, *words)
    made = tmp_path / ("made.c" if host == "single" else "made")
    span = ("--until", repr(until), "--every", repr(every))
    given = (*words, *(span if host == "single" else ()))
    done = run_pkgen("export", model, "--as", host, *given, "-o", made)
    run = run_pkgen("run", model, *words, *span)
    for one in (done, run):
        assert "Traceback" not in one.stderr
    if done.returncode == 2 or run.returncode == 2:
        pytest.skip((done.stderr or run.stderr).strip().splitlines()[0])
    assert done.returncode == 0, done.stderr
    expected = named(run.stdout) if run.stdout.count("\n") > 1 else {"t": [0.0]}
    if expected["t"][-1] < until:
        pytest.skip(f"the motion ends: {run.stderr}")
    found = HOSTS[host](made, tmp_path, of, until=until, every=every)
    # Rows at events are in those of a run alone.
    at = np.abs(np.subtract.outer(expected["t"], found["t"])).min(axis=1) < 1e-12
    assert at.sum() == len(found["t"]) == 9
    common = (expected.keys() & found.keys()) - {"t"}
    if not common:
        pytest.skip("the scene records none of the columns")
    # Other roundings (no fused multiply-add in a wheel) are other lengths of adaptive steps.
    within = 1e-9 if "--step" in words else 1e-7
    for name in common:
        wanted = np.array(expected[name])[at]
        size = max(1.0, np.nanmax(np.abs(wanted)))
        assert found[name] == pytest.approx(wanted, abs=within * size, rel=0, nan_ok=True), name
