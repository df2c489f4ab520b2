"""Random planar linkages through their singular positions, by each family of methods: a run arrives
with the motion of all others and its energy, or ends and says when; none is silent, none hangs."""

import json
import math
import random
import subprocess
import sys
from pathlib import Path

import numpy
import pytest

from conftest import seeds

ADAPTIVE = ["gauss", "dop853", "dopri5", "radau"]
FIXED = {  # the step, and the order that what a coarse one lets the energy move by falls with
    "rk4": (0.01, 4),
    "gauss4": (0.02, 8),
    "gauss2": (0.05, 4),
    "rattle": (0.01, 2),
    "lie_midpoint4": (0.02, 4),
}
HALVINGS = 3
UNTIL, EVERY, SECONDS = 2.5, 0.25, 60


class Linkage:
    """Bars by their angles q, from joints to joints; slides at the end."""

    def __init__(self, draw: random.Random):
        self.draw = draw
        self.names: list[str] = []
        self.kinetic: list[str] = []
        self.potential: list[str] = []
        self.rows: list[str] = []
        self.g = draw.choice((0.0, 2.0, 9.81))

    def angle(self, inertia: float = 0.0) -> str:
        self.names.append(f"a{len(self.names)}")
        if inertia:
            self.kinetic.append(f"{inertia!r}/2*{self.names[-1]}'^2")
        return self.names[-1]

    def bar(self, at: tuple[str, str], length: float) -> tuple[str, str]:
        """A bar of some mass that begins at a point; its other end."""
        m, a = self.draw.uniform(0.3, 2), self.angle()
        x, y = (f"{p} + {length / 2!r}*{f}({a})" for p, f in zip(at, ("cos", "sin"), strict=True))
        k = len(self.names)
        self.lets = [*getattr(self, "lets", []), f"let x{k} = {x}", f"let y{k} = {y}"]
        self.kinetic.append(f"{m!r}/2*(x{k}'^2 + y{k}'^2) + {m * length**2 / 24!r}*{a}'^2")
        self.potential.append(f"{m * self.g!r}*y{k}")
        return f"({at[0]} + {length!r}*cos({a}))", f"({at[1]} + {length!r}*sin({a}))"

    def meet(self, p: tuple[str, str], q: tuple[str, str]) -> None:
        self.rows += [f"{p[0]} - ({q[0]})", f"{p[1]} - ({q[1]})"]


def four_bar(x: Linkage) -> None:
    """Of any lengths, or of those that can lie flat: parallelogram, kite, any change point."""
    r, s, d = (x.draw.uniform(0.4, 1.5) for _ in range(3))
    lengths = x.draw.choice([(r, d, r, d), (r, s, s, r), (r, s, d, r + s - d), (r, s, d, s)])
    a, c, b, base = lengths if min(lengths) > 0.1 else (r, d, r, d)
    x.meet(x.bar(x.bar(("0", "0"), a), c), x.bar((repr(base), "0"), b))


def slider(x: Linkage) -> None:
    r = x.draw.uniform(0.4, 1.5)
    rod = x.draw.choice([r, r, r * x.draw.uniform(1, 2)])
    end = x.bar(x.bar(("0", "0"), r), rod)
    x.names.append("x")
    x.kinetic.append(f"{x.draw.uniform(0.3, 2)!r}/2*x'^2")
    x.meet(end, ("x", "0"))


def parallelograms(x: Linkage) -> None:
    """Two or three side by side, of which all but the first say no more of the cranks."""
    r, L = x.draw.uniform(0.4, 1), x.draw.uniform(0.5, 1.5)
    before = x.bar(("0", "0"), r)
    for k in range(1, x.draw.randint(3, 4)):
        crank = x.bar((repr(k * L), "0"), r)
        x.meet(x.bar(before, L), crank)
        before = crank


def closed_chain(x: Linkage) -> None:
    """Five bars or six: more than one freedom, so that singular positions are met now and then."""
    at = ("0", "0")
    for _ in range(x.draw.randint(4, 5)):
        at = x.bar(at, x.draw.uniform(0.6, 1.2))
    x.meet(at, (repr(x.draw.uniform(0.5, 1.5)), "0"))


def scissors(x: Linkage) -> None:
    """Two bars pinned at their middles, whose feet slide: the height says it twice."""
    r = x.draw.uniform(0.5, 1.5)
    a, b = x.angle(x.draw.uniform(0.2, 1)), x.angle(x.draw.uniform(0.2, 1))
    x.names.append("x")
    x.kinetic.append(f"{x.draw.uniform(0.3, 2)!r}/2*x'^2")
    x.potential.append(f"{x.g!r}*sin({a})")
    x.rows += [f"x - {r!r}*(cos({a}) + cos({b}))", f"sin({a}) + sin({b})"]
    x.rows += [f"3*(sin({a}) + sin({b})) + (x - {r!r}*(cos({a}) + cos({b})))"]


KINDS = [four_bar, slider, parallelograms, closed_chain, scissors]


def started(x: Linkage) -> tuple[numpy.ndarray, numpy.ndarray] | None:
    """A state that fulfils the rows, by Newton from a random one; None: there is none near."""
    rows = [compile(row, "row", "eval") for row in x.rows]
    known = {"cos": math.cos, "sin": math.sin}

    def phi(q):
        named = dict(zip(x.names, q, strict=True))
        return numpy.array([eval(row, known, named) for row in rows])

    def slopes(q):
        e = 1e-6 * numpy.eye(len(q))
        return numpy.array([(phi(q + d) - phi(q - d)) / 2e-6 for d in e]).T

    q = numpy.array([x.draw.uniform(-2.5, 2.5) for _ in x.names])
    for _ in range(60):
        q = q - numpy.linalg.pinv(slopes(q), rcond=1e-8) @ phi(q)
    if not numpy.abs(phi(q)).max() < 1e-14 or not numpy.abs(q).max() < 50:
        return None
    _, sizes, across = numpy.linalg.svd(slopes(q))
    rank = int((sizes > 1e-6 * sizes[0]).sum())
    if sizes[rank - 1] < 0.1 * sizes[0] or rank == len(q):
        return None
    ways = across[rank:]
    v = numpy.array([x.draw.uniform(-1, 1) for _ in ways]) @ ways
    return q, v * x.draw.uniform(2, 6) / numpy.abs(v).max()


def model(seed: int) -> tuple[str, list[str]]:
    for attempt in range(50):
        x = Linkage(random.Random(f"{seed} {attempt}"))
        x.draw.choice(KINDS)(x)
        found = started(x)
        if found:
            break
    q, v = found
    lines = ["model linkage", f"coord {', '.join(x.names)}", *getattr(x, "lets", [])]
    lines += ["kinetic " + " + ".join(x.kinetic)]
    lines += ["potential " + " + ".join(x.potential)] if x.potential else []
    lines += [f"constraint c{k}: {row} = 0" for k, row in enumerate(x.rows)]
    for name, at, rate in zip(x.names, q, v, strict=True):
        lines.append(f"start {name} = {float(at)!r}, {name}' = {float(rate)!r}")
    return "\n".join(lines) + "\n", x.names


def run(path: Path, names: list[str], *options: str) -> tuple[dict, str]:
    """Columns, and what was warned of; or no column, and the words with which it ended."""
    done = subprocess.run(
        [sys.executable, "-m", "pkgen", "run", str(path), "--json", "--until", str(UNTIL),
         "--every", str(EVERY), "--record", ",".join([*names, "energy"]), *options],
        capture_output=True, text=True, timeout=SECONDS,
    )  # fmt: skip
    assert "Traceback" not in done.stderr, done.stderr
    if done.returncode:
        assert "last valid time" in done.stderr, done.stderr
        return {}, done.stderr
    made = json.loads(done.stdout)
    rows = numpy.array(made["rows"], dtype=float).T
    columns = {x["name"]: row for x, row in zip(made["columns"], rows, strict=True)}
    return columns, str(made["report"]["warning"] or "")


def apart(one: dict, other: dict, names: list[str]) -> float:
    return max(float(numpy.abs(one[name] - other[name]).max()) for name in names)


def drift(columns: dict) -> float:
    energy = columns["energy"]
    return float(numpy.ptp(energy)) / max(1.0, float(numpy.abs(energy).max()))


def falls(path: Path, names: list[str], method: str, first: float) -> bool:
    """A step was too large for this motion: smaller ones err by its order, or it warns."""
    step, order = FIXED[method]
    for k in range(1, HALVINGS + 1):
        found, said = run(path, names, "--method", method, "--step", repr(step / 2**k))
        if not found or "energy" in said:
            return True
        if drift(found) < 2e-2 and drift(found) < first / 2 ** (order - 1):
            return True
        first = drift(found)
    return False


@pytest.mark.parametrize("seed", seeds(range(3), 13))
def test_no_linkage_is_silent(seed: int, tmp_path: Path) -> None:
    text, names = model(seed)
    path = tmp_path / "linkage.lag"
    path.write_text(text)
    exact, why = run(path, names, "--method", "dop853", "--rtol", "1e-12")
    for method in (*ADAPTIVE, *FIXED):
        step = FIXED.get(method)
        options = ["--method", method, *(["--step", str(step[0])] if step else [])]
        found, said = run(path, names, *options)
        if not found:
            continue
        assert all(numpy.isfinite(x).all() for x in found.values()), (method, text)
        moved = drift(found)
        quiet = "energy" not in said
        if quiet and step and moved > 2e-2:
            assert falls(path, names, method, moved), (method, moved, text)
        elif quiet:
            assert step or moved < 1e-5, (method, moved, text)
        assert not exact or moved > 1e-3 or apart(found, exact, names) < (0.3 if step else 1e-2), (
            method, moved, apart(found, exact, names), text, why)  # fmt: skip
