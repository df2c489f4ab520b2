"""Models for checkpoints, one of each way that a run is made, and what is common to their tests."""

import argparse
import random
from dataclasses import replace
from pathlib import Path

from conftest import case
from pkgen.api.prepare import Prepared
from pkgen.cli.commands import parsed
from pkgen.cli.run import prepared
from pkgen.run.library import load

PLANE = "coord x, y\nkinetic (x'^2 + y'^2)/2\n"
HENON = PLANE + "potential (x^2 + y^2)/2 + x^2*y - y^3/3\nstart y = 0.1, x' = 0.3\n"
MODELS = {
    "free": HENON + "conserve e = (x'^2 + y'^2 + x^2 + y^2)/2 + x^2*y - y^3/3\n",
    "damped": "coord x, y\nstate z, w\ninput u\nkinetic x'^2/2 + y'^2*(2 + sin(x))/2 + x'*y'/4\n"
    "potential x^2/2 - cos(y)\nforce x = u + sin(3*t) - 0.1*x'\nforce y = z - 0.2*y'*x'\n"
    "rate z = -z + x*w\nrate w = -w + sin(t)\nstart x = 1, y' = 0.5, z = 1\n"
    "observe sum = x + y\n",
    "bound": "coord x, y, a\n"
    "kinetic (x'^2 + y'^2)/2 + a'^2/6 + x'*a'/5\npotential 9.81*y - cos(a)\n"
    "constraint rod: x^2 + y^2 = 1\nrolling r: a' = x'*y\nstart x = 1, y' = 1, a' = 0\n",
    "rods": "coord x, y, z, w\n"
    "kinetic (x'^2 + y'^2 + 2*z'^2 + 2*w'^2)/2\npotential 9.81*(y + 2*w)\n"
    "constraint p: x^2 + y^2 = 1\nconstraint q: (z - x)^2 + (w - y)^2 = 1\n"
    "start x = 1, z = 1, w = 1, y' = 1, w' = 1\n",
    "turning": "rotation R\ncoord s\n"
    "kinetic (omega(R).x^2 + 2*omega(R).y^2 + 3*omega(R).z^2 + s'^2)/2\n"
    "potential dot(R*[0, 0, 1], [0, 0, 1])*(1 + s^2) + s^2\n"
    "start omega(R) = [0.1, 0.5, 2], s = 0.2\n",
    "events": HENON + "event section: x rising\nevent top: y' falling\n",
    "switched": "coord x, y\n"
    "kinetic x'^2/2 + y'^2/2\npotential 3*abs(x) + 20*step(-y)*y^2 + y + x*y/9\n"
    "force x = -0.01*x'\nstart x = 0.3, y = 0.5\nevent low: y falling\n",
    "struck": "coord x, y\nkinetic (1 + y^2)*x'^2/2 + 0.4*x'*y' + y'^2\n"
    "potential 0.3*step(x + 0.5*y^2 - 1) + 3*step(x^2 - 4) + 0.1*x*y\n"
    "start x = 0.1, x' = 1.2, y' = 0.3\n",
    "fast": PLANE + "let stiff = 300*(x^2 + y^4/4)\nfast stiff\npotential stiff - cos(x + y)\n"
    "start x = 0.1, y = 0.2\n",
    "short": PLANE + "potential x^2 + y^2 + exp(-400*(x - 0.5)^2)*(1 + y)\nstart x = 1, y = 0.2\n",
    "affine": PLANE + "potential x^2 + y^2*7/3 + x*y/2 + y\nforce x = -0.1*x'\nstart x = 1\n",
    "linear": PLANE + "potential x^2 + y^2*7/3 + x*y/2\nforce x = -0.1*x' + cos(t)\nstart x = 1\n",
    "chain": "size N = 40\ncoord q[1..N]\nfixed q[0] = 0, q[N+1] = 0\n"
    "kinetic sum(q[i]'^2/2, i = 1..N)\n"
    "potential sum((q[i+1] - q[i])^2/2 + (q[i+1] - q[i])^4/4, i = 0..N)\nstart q[3] = 1\n",
    "walled": "size N = 20\ncoord q[1..N]\nfixed q[0] = 0, q[N+1] = 0\n"
    "kinetic sum(q[i]'^2/2, i = 1..N)\npotential sum((q[i+1] - q[i])^2/2 + q[i], i = 0..N)\n"
    "force q[i = 1..N] = 3*step(-q[i] - 0.2)\nstart q[i = 1..N] = sin(i)/2\n",
}  # fmt: skip
BLOCKS = case("blocks")  # integrated in two
UNTIL, ROWS, STEPS = 3.0, 37, 230
SECONDS = ("seconds", "processor")


def text(name: str) -> str:
    return f"model of_{name}\n{MODELS[name]}"


def of(name: str, folder: Path, *words: str) -> Prepared:
    """A model's run, compiled; without words, for every method."""
    path = folder / f"{name}.lag"
    path.write_text(text(name))
    what = prepared(options(path, *(words or ("--diagnose", "modes"))))
    return replace(what, settings=replace(what.settings, diagnose=()))


def options(path: Path, *words: str) -> argparse.Namespace:
    return parsed(["run", str(path), *words])[1]


def methods(what: Prepared) -> list[str]:
    return [str(method["name"]) for method in load(what.library).methods()]


def by(what: Prepared, method: str, **more: object) -> Prepared:
    """The same by another method."""
    given = {"method": method, "until": UNTIL, "every": UNTIL / ROWS, "step": UNTIL / STEPS}
    settings = replace(what.settings, **{**given, "max_steps": 2000, "rtol": 1e-8, **more})
    return replace(what, settings=settings)


def run(what: Prepared, **more: object) -> tuple:
    """Code, rows, report but for its seconds, messages."""
    done = load(what.library).run(what.settings, None, what.ensemble, threads=2, **more)
    report = {k: v for k, v in done.report.items() if k not in SECONDS}
    return done.code, done.rows().tobytes(), report, done.messages


def chopped(what: Prepared, path: Path, dice: random.Random, most: int) -> tuple[tuple, int]:
    """The same, left after up to `most` steps at a time and gone on with; how often."""
    left = 0
    while True:
        after = {"checkpoint": bytes(path), "checkpoint_after": dice.randint(1, most)}
        found = run(what, **after, resume=int(left > 0))
        if found[0] != 75:
            path.unlink(missing_ok=True)
            return found, left
        left += 1
