"""The module for npm: the example of its page in a clean folder, what it refuses, its types."""

from __future__ import annotations

import json
import math
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from columns import RIG, ran

from conftest import ROOT, run_pkgen
from pkgen.back.wasm.build import missing

PAGE = (ROOT / "addons/hosts/export-js.md").read_text()
PENDULUM = ROOT / "models/double_pendulum.lag"
pytestmark = pytest.mark.skipif(
    bool(missing()) or not shutil.which("node"),
    reason=f"not here: {', '.join([*missing(), 'node'])}",
)
MORE = """
const says = (call) => {
  try { call(); return "nothing"; } catch (error) { return error.message; }
};
console.log(says(() => model.motion({ set: { m1: -1 } })));
console.log(says(() => model.motion({ set: { nobody: 1 } })));
console.log(says(() => model.motion({ start: { theta1: "1" } })));
console.log(says(() => model.motion({ method: "verlet", step: 0.1 })));
for (const name of ["rtol", "step"])
  for (const value of [0, -1, NaN]) console.log(says(() => model.motion({ [name]: value })));
for (const t of [Infinity, NaN, -1, 0.5]) console.log(says(() => motion.to(t)));
const end = [motion.t, motion.to(1), ...motion.q].join();
motion.to(1 + 1e-9);
motion.to(1 - 1e-9); // within the last step
motion.to(1);
console.log(end === [1, true, ...motion.q].join() ? "the same" : "another");
motion.free();
console.log(says(() => motion.to(2)));
const again = model.motion({ start: { theta1: 1, "theta2'": 0.5 } });
console.log(again.q[0], again.v[1], ...model.acceleration(0, again.q, again.v));
"""
WRONG = """import { load } from "double-pendulum";
const model = await load();
const motion = model.motion({ set: { l2: 0.5 }, method: "dop853" });
const there: boolean = motion.to(1);
export const x: number = motion.q[0] + motion.energy();
// @ts-expect-error
model.motion({ set: { nobody: 1 } });
// @ts-expect-error
model.motion({ method: "nothing" });
"""


def said(*words: object, cwd: Path) -> str:
    done = subprocess.run(
        list(map(str, words)), cwd=cwd, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, f"{words}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
    return done.stdout


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("js") / "double-pendulum"
    done = run_pkgen("export", PENDULUM, "--as", "js", "-o", folder)
    assert done.returncode == 0, done.stderr
    return folder


def block(language: str) -> str:
    return re.search(rf"^```{language}\n(.*?)^```", PAGE, re.M | re.S)[1]


def test_the_example_of_the_page(package: Path, tmp_path: Path) -> None:
    modules = tmp_path / "node_modules"
    modules.mkdir()
    (modules / "double-pendulum").symlink_to(package)
    (tmp_path / "main.mjs").write_text(block("js") + MORE)
    first, *rest = said("node", "main.mjs", cwd=tmp_path).splitlines()
    assert first + "\n" == block("text")
    words = ("--set", "l2=0.5", "--method", "dop853", "--rtol", "1e-12", "--until", "1")
    run = run_pkgen("run", PENDULUM, *words, "--every", "1")
    exact = [float(x) for x in run.stdout.splitlines()[-1].split(",")]
    assert [float(x) for x in first.split()] == pytest.approx([*exact[1:3], exact[-1]], abs=2e-9)
    *refused, values = rest
    wanted = ("m1 is outside", "set: there is no 'nobody'", "start.theta1: a number")
    settings = 3 * ["rtol must be positive"] + 3 * ["the step must be positive and finite"]
    times = 2 * ["time to go to is not finite"] + ["t = -1 is before", "t = 0.5 is before its last"]
    wanted = (*wanted, "verlet needs", *settings, *times, "the same", "is freed")
    for text, words in zip(refused, wanted, strict=True):
        assert words in text
    q, v, *a = map(float, values.split())
    assert (q, v) == (1, 0.5) and a[0] < -1 < 0 < abs(a[1])


WATCHED = f"""{RIG}rotation R
kinetic (1 [kg*m^2])*(omega(R).x^2 + 1.5*omega(R).y^2 + 2*omega(R).z^2)
start omega(R) = [0.1, 0.2, m*(0.05 [1/kg/s])]
start s = 0.25
observe power = F*x'
observe hidden_time = t*x
event low: x + (2 [m]) falling
event middle: x falling
event late: t - (4 [s]) rising stop
"""
OF_ALL = """import { load, description } from "./rig/index.js";
const model = await load();
const set = { m: 3, F: 14 };
const start = { x: 2.5, "x'": -0.5, s: -3, "omega(R).y": 0.7 };
const motion = model.motion({ set, start, method: "rk4", step: 0.01 });
const reached = motion.to(3);
const rates = ["x'", "omega(R).x", "omega(R).y", "omega(R).z", "R.w", "R.x", "R.y", "R.z", "s"];
const { power, hidden_time } = motion.outputs();
const own = model.motion({ method: "dop853", t: 2 });
own.to(2.5);
const says = (call) => {
  try { call(); return "nothing"; } catch (error) { return error.message; }
};
console.log(JSON.stringify({
  reached, t: motion.t, q: [...motion.q], v: [...motion.v], power, hidden_time,
  energy: motion.energy(), crossings: motion.crossings().map((x) => [x.event, x.t]),
  again: motion.crossings().length, steps: motion.steps,
  own: [own.t, ...own.q, own.v[0]], names: rates,
  a: [...model.acceleration(0, [2], [1, ...Array(7).fill(0), 0], { set })],
  ended: [motion.to(5), motion.t, motion.crossings().map((x) => x.event).pop()],
  wrong: [[[], own.v], [[1], [1]]].map((x) => says(() => model.acceleration(0, ...x))),
}));
"""


def test_inputs_followers_states_rotations_outputs_and_events(tmp_path: Path) -> None:
    (tmp_path / "rig.lag").write_text(WATCHED)
    done = run_pkgen(
        *("export", tmp_path / "rig.lag", "--as", "js", "-o", tmp_path / "rig", "--set", "F=4")
    )
    assert done.returncode == 0, done.stderr
    (tmp_path / "main.mjs").write_text(OF_ALL)
    found = json.loads(said("node", "main.mjs", cwd=tmp_path))
    given = ("m=3", "F=14"), ("x=2.5", "x'=-0.5", "s=-3", "omega(R).y=0.7")
    words = [w for kind, each in zip(("--set", "--start"), given, strict=True)
             for one in each for w in (kind, one)]  # fmt: skip
    rows = ran(tmp_path / "rig.lag", *words, "--method", "rk4", "--step", "0.01",
               "--until", "3", "--every", "0.5")  # fmt: skip
    last = {name: column[-1] for name, column in rows.items()}
    assert found["reached"] is True and found["t"] == last["t"] == 3 and found["steps"] >= 300
    assert found["q"] == pytest.approx([last["x"]], abs=1e-10)
    assert sorted(found["v"]) == pytest.approx(sorted(last[n] for n in found["names"]), abs=1e-10)
    assert len(set(found["v"])) == len(found["v"])
    for name in ("power", "hidden_time", "energy"):
        assert found[name] == pytest.approx(last[name], abs=1e-9), name
    # m x'' = F - 4 m x about F/(4 m), from 2.5 with the rate -0.5.
    middle, size = 14 / 12, math.hypot(2.5 - 14 / 12, 0.25)
    phase = math.atan2(0.25, 2.5 - middle)
    first = (math.acos(-middle / size) - phase) / 2
    assert [name for name, _ in found["crossings"]] == ["middle"] and found["again"] == 0
    assert found["crossings"][0][1] == pytest.approx(first, abs=1e-7)
    t, x, rate = found["own"]  # from x = m/2 = 1 at t = 2, about F/(4 m) = 1/2
    assert t == 2.5
    assert [x, rate] == pytest.approx([(1 + math.cos(1)) / 2, -math.sin(1)], abs=1e-8)
    stays, end, last_event = found["ended"]
    assert not stays and end == pytest.approx(4, abs=1e-12) and last_event == "late"
    assert found["a"][0] == pytest.approx(14 / 3 - 8)
    assert all("1 coordinates and 9 rates" in text for text in found["wrong"])


@pytest.mark.long
def test_npm_takes_it_and_typescript_reads_its_types(package: Path, tmp_path: Path) -> None:
    said("npm", "pack", package, cwd=tmp_path)
    (tmp_path / "package.json").write_text('{"name": "user", "type": "module"}\n')
    archive = next(tmp_path.glob("*.tgz"))
    asked = ["npm", "install", "--no-audit", "--no-fund", f"./{archive.name}"]
    said(*asked, cwd=tmp_path)
    (tmp_path / "main.mjs").write_text(block("js"))
    assert said("node", "main.mjs", cwd=tmp_path) == block("text")
    done = subprocess.run(
        ["npm", "install", "--no-audit", "--no-fund", "typescript@5"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        pytest.skip("no registry has typescript here")
    (tmp_path / "use.ts").write_text(WRONG)
    flags = ["--strict", "--noEmit", "--module", "nodenext", "--target", "es2022"]
    said("node_modules/.bin/tsc", *flags, "use.ts", cwd=tmp_path)
