"""Rows on each host are those of `pkgen run`: a table of models, values and methods, and random
ones."""

from __future__ import annotations

import itertools
import json
import random
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from columns import RIG

from conftest import HOSTED, ROOT, run_pkgen, table
from pkgen.back.host.data import tables
from pkgen.back.wasm.build import missing
from pkgen.methods import METHODS

MODELS = HOSTED
Rows = dict[str, list[float]]
IN_WHEEL = """import json, {name} as d
rows = d.Model().run({until!r}, every={every!r})
print(json.dumps({{name: rows[name].tolist() for name in rows.columns}}))
"""
IN_NODE = """import {{ load }} from "{made}/index.js";
const motion = (await load()).motion();
const rows = [];
for (let k = 0, on = true; on && k <= {count}; k++) {{
  on = motion.to(k * {every!r});
  const seen = [motion.energy(), ...Object.values(motion.outputs())];
  rows.push([motion.t, ...motion.q, ...motion.v, ...seen]);
}}
console.log(JSON.stringify(rows));
"""
IN_RUST = """use {name}::{{Motion, Parameters, Settings}};
fn main() {{
    let mut m = Motion::new(&Parameters::default(), &Settings::default()).unwrap();
    for k in 0..={count} {{
        let on = m.to(k as f64 * {every:e}).unwrap();
        let (q, v, y) = (m.q().to_vec(), m.v().to_vec(), m.outputs().to_vec());
        println!("{{:?}}", [vec![m.t()], q, v, vec![m.energy()], y].concat());
        if !on {{ break; }}
    }}
}}
"""
MANIFEST = """[package]
name = "user"
version = "0.1.0"
edition = "2021"
[dependencies]
{crate} = {{ path = "{made}" }}
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


def columns(rows: list[list[float]], of: dict) -> Rows:
    found = tables(of)
    names = [[q["name"] for q in found[kind]] for kind in ("coordinates", "rates", "outputs")]
    heads = ["t", *names[0], *names[1], "energy", *names[2]]
    return dict(zip(heads, map(list, zip(*rows, strict=True)), strict=True))


def node(made: Path, folder: Path, of: dict, **how: float) -> Rows:
    text = IN_NODE.format(made=made, count=round(how["until"] / how["every"]), **how)
    (folder / "main.mjs").write_text(text)
    return columns(json.loads(said("node", "main.mjs", cwd=folder)), of)


def crate(made: Path, folder: Path, of: dict, **how: float) -> Rows:
    name = of["model"].lower()
    (folder / "src").mkdir()
    count = round(how["until"] / how["every"])
    (folder / "src/main.rs").write_text(IN_RUST.format(name=name, count=count, **how))
    (folder / "Cargo.toml").write_text(MANIFEST.format(crate=name, made=made))
    lines = said("cargo", "run", "-q", cwd=folder).splitlines()
    return columns([json.loads(line) for line in lines], of)


def one_file(made: Path, folder: Path, of: dict, **how: float) -> Rows:
    flags = ["-O2", "-march=native", "-ffp-contract=off", "-fno-math-errno"]
    said("gcc", *flags, made, "-o", "one", "-lm", cwd=folder)
    return named(said("./one", cwd=folder))


def unit(made: Path, folder: Path, of: dict, **how: float) -> Rows:
    (path,) = made.glob("*.fmu")
    text = IN_FMPY.format(made=path, **how)
    return json.loads(said(sys.executable, "-c", text, cwd=folder).splitlines()[-1])


HOSTS = {"python": wheel, "js": node, "single": one_file, "fmu": unit, "rust": crate}


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


def compare(host: str, model: Path, folder: Path, words: list, until: float, every: float) -> None:
    """Compares the columns that the host and a run have; skips if either refuses the model."""
    if host == "js" and (missing() or not shutil.which("node")):
        pytest.skip("no node, clang or wasi-libc here")
    if host == "rust" and not shutil.which("cargo"):
        pytest.skip("no cargo here")
    if host == "fmu":
        pytest.importorskip("fmpy.fmi3")
    scene = words[words.index("--scene") :][:2] if "--scene" in words else []  # it has columns
    of = json.loads(run_pkgen("describe", model, *scene, "--json").stdout)
    made = folder / ("made.c" if host == "single" else "made")
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
    ends = expected["t"][-1] < until
    if ends and (host == "fmu" or "stopped at event" not in run.stderr):
        pytest.skip(f"the motion ends: {run.stderr}")
    found = HOSTS[host](made, folder, of, until=until, every=every)
    # Other roundings (no fused multiply-add in a wheel) are other lengths of adaptive steps.
    within = 1e-9 if "--step" in words else 1e-7
    # Rows at events are in those of a run alone.
    off = np.abs(np.subtract.outer(found["t"], expected["t"]))
    assert off.min(axis=1).max() < within and found["t"][-1] == pytest.approx(expected["t"][-1])
    assert len(found["t"]) == int(expected["t"][-1] / every + 1e-9) + 1 + ends
    common = (expected.keys() & found.keys()) - {"t"}
    if not common:
        pytest.skip("the scene records none of the columns")
    for name in common:
        wanted = np.array(expected[name])[off.argmin(axis=1)]
        size = max(1.0, np.nanmax(np.abs(wanted)))
        assert found[name] == pytest.approx(wanted, abs=within * size, rel=0, nan_ok=True), name


PUSHED = f"""{RIG}observe power = F*x'
scene pushed
  set m = 3, F = -2
  start x' = -0.5, s = -2
  until 1
  expect x = s*(1 [m])*cos(t/(1 [s])) within 1e9 [m]
end
"""
GIVEN = ["--set", "l2=0.5", "--start", "theta1=20 [deg]", "--start", "theta2'=0.7"]
# A model, values, the span and the distance of rows; the last one ends at an event.
TABLE = {
    "inputs": (PUSHED, ["--scene", "pushed"], 1.0, 0.125),
    "values": (ROOT / "models/double_pendulum.lag", GIVEN, 1.0, 0.125),
    "rotation": (
        ROOT / "models/bodies/heavy_top_rotation.lag", ["--start", "omega(R).x=0.3"], 0.5, 0.0625,
    ),
    "event": (ROOT / "models/particles/thrown_stone.lag", [], 9.0, 0.25),
}  # fmt: skip
BY = {"adaptive": ["--method", "dop853"], "fixed": ["--method", "rk4", "--step", "0.0125"]}
QUICK = {
    ("python", "rotation", "adaptive"),
    ("js", "inputs", "fixed"),
    ("single", "values", "fixed"),
}
# A unit that an event ends is in addons/fmu. One file has fixed steps, without rotations, and no
# step of it ends at a switch.
NOT = {("fmu", "event", by) for by in BY} | {("single", case, "adaptive") for case in TABLE}
NOT |= {("single", "rotation", "fixed"), ("single", "event", "fixed")}


@pytest.mark.parametrize(
    ("host", "case", "by"),
    [
        pytest.param(*key, marks=() if key in QUICK else pytest.mark.long)
        for key in itertools.product(HOSTS, TABLE, BY)
        if key not in NOT
    ],
)
def test_rows_are_those_of_a_run(host: str, case: str, by: str, tmp_path: Path) -> None:
    model, words, until, every = TABLE[case]
    if isinstance(model, str):
        (tmp_path / "rig.lag").write_text(model)
        model = tmp_path / "rig.lag"
    compare(host, model, tmp_path, [*words, *BY[by]], until, every)


def test_rows_within_a_step_of_gauss_that_ends_at_a_knot(tmp_path: Path) -> None:
    model = ROOT / "models/bodies/quarter_car.lag"
    compare("python", model, tmp_path, ["--method", "gauss"], 0.5, 0.05)


@pytest.mark.long
@pytest.mark.parametrize("host", HOSTS)
@pytest.mark.parametrize("seed", range(6))
def test_rows_of_random_models_are_those_of_a_run(seed: int, host: str, tmp_path: Path) -> None:
    chance = random.Random(f"{seed} {host}")
    model = chance.choice(MODELS)
    of = json.loads(run_pkgen("describe", model, "--json").stdout)
    until = chance.choice([0.25, 0.5, 1.0])
    words = chosen(chance, of, host, until / 8)
    print(model.stem, *words)
    compare(host, model, tmp_path, words, until, until / 8)
