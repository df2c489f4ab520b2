"""The hosts of `python -m bench exports`: how each is built as its users do, and what its rows are.

All start where the model does, and make STEPS steps of rk4 of length STEP, a row each.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pkgen.back.host.data import tables

from .builds import OUTPUT

ROOT = Path(__file__).resolve().parent.parent
METHOD, STEP, STEPS = "rk4", 2.0**-7, 16
FREE = ["-ffp-contract=off", "-fno-math-errno"]
Rows = dict[str, list[float]]


@dataclass(frozen=True)
class Case:
    """A model that is exported: its path, its description, the folder it was exported to (or of its
    one file), one of its own, and what `pkgen run` gives."""

    model: Path
    of: dict
    made: Path
    folder: Path
    expected: Callable[..., Rows]

    @property
    def name(self) -> str:
        return self.of["model"]

    def off(self, found: Rows, *words: str) -> float:
        """The largest difference from a run, in units of each column's size, at least 1."""
        expected = self.expected(*words)
        common = [name for name in expected if name in found and name != "t"]
        assert len(common) >= 2, (list(found), list(expected))
        assert all(len(found[name]) == len(expected["t"]) for name in common)
        worst = 0.0
        for name in common:
            size = max(1.0, *map(abs, expected[name]))
            gaps = (abs(a - b) for a, b in zip(found[name], expected[name], strict=True))
            worst = max(worst, *(gap / size for gap in gaps))
        return worst

    def filled(self, text: str) -> str:
        words = {"NAME": self.name, "STEPS": str(STEPS), "STEP": repr(STEP), "METHOD": METHOD}
        for word, value in words.items():
            text = text.replace(f"@{word}@", value)
        return text

    def columns(self, said: str) -> Rows:
        """Lines of q, v, outputs and energy, as far as they go."""
        of = tables(self.of)
        names = [q["name"] for kind in ("coordinates", "rates", "outputs") for q in of[kind]]
        rows = [[float(x) for x in line.split()] for line in said.splitlines()]
        return dict(zip([*names, "energy"], map(list, zip(*rows, strict=True)), strict=False))


def _ran(*words: object, cwd: Path, **more: str) -> str:
    done = subprocess.run(
        list(map(str, words)),
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **more},
    )
    if done.returncode:
        raise RuntimeError(f"{words[0]}: {done.stdout[-500:]}{done.stderr[-1500:]}")
    return done.stdout


def _enumerated(path: Path) -> dict[str, float]:
    import fmpy

    variables = fmpy.read_model_description(str(path)).modelVariables
    (choice,) = (v for v in variables if v.name == "integrator.method")
    number = next(int(i.value) for i in choice.declaredType.items if i.name == METHOD)
    return {"integrator.step": STEP, "integrator.method": number}


def _unit(case: Case) -> float:
    import fmpy
    from fmpy.validation import validate_fmu

    if problems := validate_fmu(str(case.made)):
        raise RuntimeError(f"{case.made.name}: {problems}")
    rows = fmpy.simulate_fmu(
        str(case.made),
        fmi_type="CoSimulation",
        stop_time=STEP * STEPS,
        output_interval=STEP,
        start_values=_enumerated(case.made),
    )
    return case.off({name: rows[name].tolist() for name in rows.dtype.names})


def _exchanged(case: Case) -> float:
    """Accelerations at states beside the start, against the kernels', of their size."""
    import fmpy
    import numpy as np

    import pkgen

    found = pkgen.load(case.model)
    about = fmpy.read_model_description(str(case.made))
    unit = fmpy.fmi3.FMU3Model(
        guid=about.instantiationToken,
        unzipDirectory=fmpy.extract(str(case.made), str(case.folder / "unit")),
        modelIdentifier=about.modelExchange.modelIdentifier,
        instanceName="one",
    )
    unit.instantiate()
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    unit.enterContinuousTimeMode()
    n, n_q = unit.getNumberOfContinuousStates(), len(found.coordinates)
    chance, worst, compared = random.Random(1), 0.0, 0
    rates = (np.ctypeslib.ctypes.c_double * n)()
    for t in range(20):
        x = np.array(found.start) + [chance.uniform(-0.1, 0.1) for _ in range(n)]
        if not np.all(np.isfinite(found.acceleration(x[:n_q], x[n_q:], float(t)))):
            continue
        unit.setTime(float(t))
        unit.setContinuousStates(np.ctypeslib.as_ctypes(x), n)
        unit.enterEventMode()  # a jump of the state may cross switches, which events alone move
        unit.updateDiscreteStates()
        unit.enterContinuousTimeMode()
        unit.getContinuousStates(np.ctypeslib.as_ctypes(x), n)  # moved onto the constraints
        a = found.acceleration(x[:n_q], x[n_q:], float(t))
        unit.getContinuousStateDerivatives(rates, n)
        size = max(float(np.max(np.abs(a))), 1e-9)
        worst = max(worst, float(np.max(np.abs(np.array(rates)[n_q:] - a))) / size)
        compared += 1
    unit.freeInstance()
    assert compared > 5
    return worst


IN_WHEEL = """
import json
import @NAME@ as d
rows = d.Model().run(@STEPS@ * @STEP@, every=@STEP@, method="@METHOD@", step=@STEP@)
print(json.dumps({name: rows[name].tolist() for name in rows.columns}))
"""


def _wheel(case: Case) -> float:
    with zipfile.ZipFile(case.made) as archive:
        archive.extractall(case.folder / "in")
    text = case.filled(IN_WHEEL)
    return case.off(json.loads(_ran(sys.executable, "-c", text, cwd=case.folder / "in")))


IN_C = """
#include <stdio.h>
#include <stdlib.h>
#include "@NAME@.h"
#include "include/pk/pk.h"
int main(void)
{
    const struct pk_system *s = &@NAME@_system;
    void *p = calloc(1, s->params_size);
    if (s->families.block_size) {
        s->families.set_sizes(p);
        s->families.attach(p, calloc(1, s->families.block_size(p) + 1));
    }
    s->defaults(p);
    if (s->prepare(p))
        return 2;
    const size_t n = pk_system_count(s, p), n_q = pk_system_coordinates(s, p);
    const struct pk_problem problem = {.system = s, .params = p};
    const struct pk_method *method = pk_method_find("@METHOD@");
    struct pk_options options = pk_options_default();
    options.h = @STEP@;
    double *q = calloc(2 * n + s->n_observed + 1, sizeof *q), *v = q + n, *y = v + n;
    double u[64] = {0};
    s->start(p, q, v);
    const size_t size = pk_integrator_size(&problem, method);
    struct pk_integrator it;
    if (pk_integrator_init(&it, &problem, method, &options, 0, q, v, malloc(size), size) < 0)
        return 3;
    for (int k = 0; k <= @STEPS@; k++) {
        if (pk_integrator_to(&it, k * @STEP@) < 0)
            return 4;
        for (size_t i = 0; i < n_q; i++)
            printf("%.17g ", it.q[i]);
        for (size_t i = 0; i < n; i++)
            printf("%.17g ", it.v[i]);
        if (s->observe)
            s->observe(p, it.t, it.q, it.v, u, y);
        for (size_t i = 0; i < s->n_observed; i++)
            printf("%.17g ", y[i]);
        printf("%.17g\\n", s->energy ? s->energy(p, it.t, it.q, it.v, u) : 0.0);
    }
    return 0;
}
"""


def _source(case: Case) -> float:
    (case.made / "main.c").write_text(case.filled(IN_C))
    files = sorted(str(path.relative_to(case.made)) for path in case.made.rglob("*.c"))
    _ran("gcc", "-std=c11", "-O0", *FREE, *files, "-o", "main", "-lm", cwd=case.made)
    return case.off(case.columns(_ran(case.made / "main", cwd=case.made)))


def _single(case: Case) -> float:
    flags = ("-std=c99", "-O2", *FREE, "-DPK_PORTABLE")
    _ran("gcc", *flags, case.made.name, "-o", "one", "-lm", cwd=case.made.parent)
    head, *lines = _ran(case.made.parent / "one", cwd=case.folder).splitlines()
    columns = zip(*(map(float, line.split(",")) for line in lines), strict=True)
    rows = {name: list(column) for name, column in zip(head.split(","), columns, strict=True)}
    return case.off(rows, "--portable")


ON_BOARD = """
#include <stdio.h>
#include "@NAME@_step.h"
static struct @NAME@_motion m;
int main(void)
{
    if (@NAME@_begin(&m, @STEP@))
        return 1;
    for (int k = 0; k <= @STEPS@; k++) {
        if (k && @NAME@_step(&m))
            return 2;
        for (int i = 0; i < @NAME@_N@STATES@; i++)
            printf("%.17g ", (double)m.q[i]);
        for (int i = 0; i < @NAME@_N; i++)
            printf("%.17g ", (double)m.v[i]);
        puts("");
    }
    return 0;
}
"""


def _firmware(case: Case) -> float:
    """Of doubles, on this machine."""
    (case.folder / "main.c").write_text(
        case.filled(ON_BOARD).replace("@STATES@", f" - {len(case.of['states'])}")
    )
    folder = case.made / "src" if (case.made / "src").exists() else case.made
    flags = ("-std=c11", "-O2", *FREE, "-DPK_PORTABLE", f"-I{folder}")
    files = sorted(folder.glob("*.c"))
    _ran("gcc", *flags, "main.c", *files, "-o", "main", "-lm", cwd=case.folder)
    said = _ran(case.folder / "main", cwd=case.folder)
    return case.off(case.columns(said), "--portable")


MANIFEST = """[package]
name = "user"
version = "0.1.0"
edition = "2021"
[dependencies]
@NAME@ = { path = "../made" }
"""
IN_RUST = """use @NAME@::{Error, Motion, Parameters, Settings};
fn main() -> Result<(), Error> {
    let settings = Settings { method: "@METHOD@".into(), step: @STEP@, ..Default::default() };
    let mut motion = Motion::new(&Parameters::default(), &settings)?;
    for k in 0..=@STEPS@ {
        motion.to(k as f64 * @STEP@)?;
        for x in motion.q().iter().chain(motion.v()).chain(&motion.outputs()) {
            print!("{x:.17e} ");
        }
        println!("{:.17e}", motion.energy());
    }
    Ok(())
}
"""


def _crate(case: Case) -> float:
    """Its own doctest, then a program that depends on it."""
    target = {"CARGO_TARGET_DIR": str(OUTPUT / "cargo"), "CFLAGS": "-O0"}  # for time's sake
    if "1 passed" not in _ran("cargo", "test", cwd=case.made, **target):
        raise RuntimeError("cargo test: no test has passed")
    user = case.folder / "user"
    (user / "src").mkdir(parents=True)
    (user / "Cargo.toml").write_text(case.filled(MANIFEST))
    (user / "src/main.rs").write_text(case.filled(IN_RUST))
    return case.off(case.columns(_ran("cargo", "run", "-q", cwd=user, **target)))


IN_NODE = """import { load, description } from "../made/index.js";
const model = await load();
const motion = model.motion({ method: "@METHOD@", step: @STEP@ });
const names = description.outputs.filter((y) => !y.hidden).map((y) => y.name);
for (let k = 0; k <= @STEPS@; k++) {
  motion.to(k * @STEP@);
  const outputs = motion.outputs();
  const q = [...motion.q].slice(0, description.coordinates.length);
  const y = names.map((name) => outputs[name]);
  console.log([...q, ...motion.v, ...y, motion.energy()].join(" "));
}
"""


def _module(case: Case) -> float:
    (case.folder / "user").mkdir()
    (case.folder / "user/main.mjs").write_text(case.filled(IN_NODE))
    return case.off(case.columns(_ran("node", "main.mjs", cwd=case.folder / "user")))


IN_OCTAVE = """1;
addpath ../made
build();
[t, y, more] = @NAME@((0:@STEPS@) * @STEP@, 'method', '@METHOD@', 'step', @STEP@);
for k = 1:numel(t)
    printf('%.17g ', y(k, :), more.outputs(k, :)); printf('%.17g\\n', more.energy(k));
end
"""


def _mex(case: Case) -> float:
    (case.folder / "user").mkdir()
    (case.folder / "user/script.m").write_text(case.filled(IN_OCTAVE))
    command = ("octave-cli", "--quiet", "--no-gui", "script.m")
    return case.off(case.columns(_ran(*command, cwd=case.folder / "user")))


@dataclass(frozen=True)
class Host:
    """A column: words of the export, what it is validated by, the difference, tools it takes."""

    words: tuple[str, ...]
    by: str
    off: Callable[[Case], float]
    tools: tuple[str, ...] = ()
    within: float = 1e-9

    def is_here(self) -> bool:
        return all(map(shutil.which, self.tools))


FIXED = ("--method", METHOD, "--step", repr(STEP), "--scalar", "double")
ROWS = (*FIXED, "--until", repr(STEP * STEPS), "--every", repr(STEP))
_SCHEMAS = "FMPy in co-simulation, the standard's schemas"
HOSTS = {
    "FMI 3": Host(("fmu",), _SCHEMAS, _unit),
    "FMI 3 rates": Host(("fmu",), "FMPy in model exchange, the kernels", _exchanged, within=1e-12),
    "FMI 2": Host(("fmu", "--fmi", "2"), _SCHEMAS, _unit),
    "python": Host(("python",), "Python, where it is unpacked", _wheel),
    "source": Host(("source",), "gcc, a main of 40 lines", _source),
    "single": Host(("single", *ROWS), "gcc -DPK_PORTABLE, what it prints", _single),
    "freestanding": Host(("freestanding", *FIXED), "gcc, in doubles on this machine", _firmware),
    "arduino": Host(("arduino", *FIXED), "the same of its src", _firmware),
    "rust": Host(("rust",), "cargo test, a program", _crate, ("cargo",)),
    "js": Host(("js",), "Node", _module, ("node", "clang", "wasm-ld")),
    "matlab": Host(("matlab",), "Octave's mkoctfile", _mex, ("mkoctfile", "octave-cli")),
}
