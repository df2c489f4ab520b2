"""`python -m bench families [--only TEXT] [--docs]`: what families kept as loops can do, beside
their members written out.

A row a feature: the model with a few members as loops and as straight-line code, the largest
difference of a recorded number relative to the largest of its kind (integrators that choose their
steps by rounding are held to a tolerance of 1e-13); and with many members the time of a run, a
member and an evaluation of the accelerations (a tolerance of LOOSE). Exit code 4 if a difference is
above SAME.
"""

from __future__ import annotations

import argparse
import csv
import json
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from . import tables
from .report import write_table
from .systems import ROOT

PAGE = ROOT / "docs/dev/families.md"
SAME = 1e-11
HEAD = ("feature", "members", "off", "members", "method", "evaluations", "ns a member", "seconds")
LOOSE = "1e-8"
TIGHT = ("--method", "dop853", "--rtol", "1e-13")
# Up to how many coordinates members are written out.
RUN = "import sys; from pkgen.scenes import lengths; lengths.UNROLL = lengths.UNROLL_MEMBERS = {}\n"
RUN += "from pkgen.__main__ import main; sys.exit(main(sys.argv[1:]))"

FPUT = """\
param k = 1
coord q[1..N]
fixed q[0] = 0, q[N+1] = 0
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum(k*(q[i+1] - q[i])^2/2 + (q[i+1] - q[i])^3/12, i = 0..N)
start q[i = 1..N] = sin(pi*i/(N + 1))
"""
PENDULUMS = """\
coord q[1..N]
fixed q[0] = 0, q[N+1] = 2*pi
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum((q[i+1] - q[i])^2/2, i = 0..N) + sum(0.01*(1 - cos(q[i])), i = 1..N)
start q[i = 1..N] = 4*atan(exp(0.1*(i - N/2)))
"""
HEAT = """\
state u[1..N]
fixed u[0] = cos(t)
free u[N+1]
rate u[i = 1..N] = u[i-1] - 2*u[i] + u[i+1] - u[i]^3
start u[i = 1..N] = sin(i)
"""
DASHPOTS = """\
coord q[1..N]
state e[1..N]
fixed q[0] = 0
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum((q[i] - q[i-1])^2/2 + (q[i] - q[i-1] - e[i])^2/4, i = 1..N)
rate e[i = 1..N] = q[i] - q[i-1] - e[i]
start q[N] = 1
"""
KURAMOTO = """\
param w[i = 1..N] = 0.5*sin(7*i)
state a[1..N]
rate a[i = 1..N] = w[i] + 1.5/N*sum(sin(a[j] - a[i]), j = 1..N)
start a[i = 1..N] = 3*cos(5*i)
"""
LINKS = """\
coord theta[1..N]
let x[0] = 0
let y[0] = 0
let x[i = 1..N] = x[i-1] + sin(theta[i])/N
let y[i = 1..N] = y[i-1] - cos(theta[i])/N
kinetic sum((x[i]'^2 + y[i]'^2)/(2*N), i = 1..N)
potential sum(y[i]/N, i = 1..N)
start theta[i = 1..N] = 0.5*i/N
"""
RODS = """\
param l = 1/N
param b = 1/N
coord x[1..N], y[1..N]
fixed x[0] = 0, y[0] = 0
kinetic sum(l*(x[i]'^2 + y[i]'^2)/2, i = 1..N)
potential sum(l*9.81*y[i], i = 1..N)
constraint rod[i = 1..N]: (x[i] - x[i-1])^2 + (y[i] - y[i-1])^2 = l^2
start x[i = 1..N] = l/(2*sin(b/2))*sin(i*b), y[i = 1..N] = l/(2*sin(b/2))*(cos(i*b) - 1)
"""
SPINS = """\
rotation R[1..N]
free R[N+1]
kinetic sum(dot(omega(R[i]), omega(R[i]))/2 + omega(R[i]).z^2/4, i = 1..N)
potential -sum(dot(R[i]*[0, 0, 1], R[i+1]*[0, 0, 1]) + (R[i]*[0, 0, 1]).z/5, i = 1..N)
start R[i = 1..N] = rot([1, cos(i), 0], 1 + sin(i))
start omega(R[i = 1..N]) = [0, 0, 2]
"""
JOINTS = """\
param l = 1/N
coord x[1..N], y[1..N], z[1..N]
rotation R[1..N]
let head[i = 1..N] = [x[i], y[i], z[i]] - R[i]*[l/2, 0, 0]
let tail[i = 1..N] = [x[i], y[i], z[i]] + R[i]*[l/2, 0, 0]
kinetic sum(l*(x[i]'^2 + y[i]'^2 + z[i]'^2)/2, i = 1..N)
kinetic sum(l^3*(omega(R[i]).x^2/50 + (omega(R[i]).y^2 + omega(R[i]).z^2)/24), i = 1..N)
potential sum(l*9.81*z[i], i = 1..N)
constraint wall: head[1] = [0, 0, 0]
constraint joint[i = 1..N-1]: tail[i] = head[i+1]
start x[i = 1..N] = (i - 0.5)*l
start omega(R[i = 1..N]) = [1, 0, 0]
"""
MAGNETS = """\
coord q[1..N]
let c = sum(cos(q[i]), i = 1..N)/N
let s = sum(sin(q[i]), i = 1..N)/N
kinetic sum(q[i]'^2/2, i = 1..N)
potential -0.75*N*(c^2 + s^2)
start q[i = 1..N] = sin(3*i) - sum(sin(3*j), j = 1..N)/N
"""
ROCKETS = """\
coord q[1..N]
state m[1..N], f[1..N]
kinetic sum((1 + m[i]^2)*q[i]'^2/2, i = 1..N)
potential sum((q[i+1] - q[i])^2/2, i = 1..N-1)
rate m[i = 1..N] = q[i] - m[i]
rate f[i = 1..N] = -f[i] + m[i]'^2
force q[i = 1..N] = f[i]'
start q[i = 1..N] = sin(i), m[i = 1..N] = 0.5
"""
SEEN = (
    FPUT
    + """\
let a[1] = q[1]
let a[i = 2..N] = 0.99*a[i-1] + q[i]
observe last = a[N]
observe speed = a[N]'
"""
)
HELD = """\
param l = 1/N
param c = 0.6
coord q[1..N]
let x[0] = 0
let y[0] = 0
let x[i = 1..N] = x[i-1] + l*cos(q[i])
let y[i = 1..N] = y[i-1] + l*sin(q[i])
kinetic sum((x[i]'^2 + y[i]'^2)/(2*N), i = 1..N)
potential sum(9.81*y[i]/N, i = 1..N)
constraint across: x[N] = cos(c)
constraint up: y[N] = 0
start q[i = 1..N] = c*tanh(50*(i - (N + 1)/2))
"""
MEMBERS = "k,q[1]\n" + "".join(f"{1 + k / 100},{k / 50}\n" for k in range(50))


@dataclass(frozen=True)
class Case:
    feature: str
    text: str
    many: int
    until: float
    words: tuple[str, ...] = TIGHT
    members: str = ""


CASES = (
    Case("a few members recorded", FPUT, 100_000, 20, (*TIGHT, "--record", "q[1],q[N]',energy")),
    Case("events of members and sums", FPUT + "event half: q[3] falling\n", 100_000, 20),
    Case("ensembles", FPUT, 1000, 20, ("--method", "verlet", "--step", "0.01"), MEMBERS),
    Case("states alone", HEAT, 100_000, 5),
    Case("states beside coordinates", DASHPOTS, 100_000, 5),
    Case("sums over all in rates", KURAMOTO, 1000, 2),
    Case("chains of links", LINKS, 1000, 0.1),
    Case("constraints, a rope of rods", RODS, 10_000, 0.01),
    Case("rotations", SPINS, 10_000, 5, (*TIGHT, "--record", "R[1],omega(R[N]),energy")),
    Case("gauss", PENDULUMS, 10_000, 20, ("--method", "gauss", "--rtol", "1e-13")),
    Case("gauss2 under constraints", RODS, 1000, 0.02, ("--method", "gauss2", "--step", "0.001")),
    Case(
        "constraints beside rotations",
        JOINTS,
        1000,
        0.001,
        (*TIGHT, "--record", "z[1],z[N],R[N],energy"),
    ),
    Case(
        "radau5 with rotations",
        SPINS,
        1000,
        1,
        ("--method", "radau5", "--step", "0.05", "--record", "R[1],omega(R[N]),energy"),
    ),
    Case("totals that members feel", MAGNETS, 100_000, 5),
    Case("the same by gauss2", MAGNETS, 10_000, 5, ("--method", "gauss2", "--step", "0.05")),
    Case("rates of states in forces", ROCKETS, 100_000, 2),
    Case("lets of outputs alone", SEEN, 100_000, 20, (*TIGHT, "--record", "q[1],last,speed")),
    Case("chains whose ends are held", HELD, 1000, 0.01),
    Case("gauss2 of chains of links", LINKS, 100, 0.05, ("--method", "gauss2", "--step", "0.002")),
    Case("an output for each index", f"{FPUT}observe d[i = 0..N] = q[i+1] - q[i]\n", 10_000, 20),
)
FEW = 20


def ran(case: Case, size: int, unrolled: int, folder: Path) -> tuple[list[list[float]], dict]:
    """Rows at ten times, and the report."""
    model, out = folder / "model.lag", folder / "rows.csv"
    model.write_text(f"model family\nsize N = {size}\n{case.text}")
    # Of many members differences of neighbours are rounded by more than a tight tolerance.
    words = [word.replace("[N]", f"[{size}]") for word in case.words]
    words = [LOOSE if size > FEW and word == "1e-13" else word for word in words]
    if case.members:
        (folder / "members.csv").write_text(case.members)
        words += ["--ensemble", folder / "members.csv", "--threads", 1]
    if size > FEW and "--record" not in words:
        words += ["--record", re.search(r"(?:coord|state) (\w+)", case.text)[1] + "[1]"]
    words += ["--until", case.until, "--every", case.until / 10, "--json", "-o", out]
    words += ["--max-seconds", 100]  # twenty bodies on joints, written out, take some
    command = [sys.executable, "-c", RUN.format(unrolled), "run", model, *words]
    done = subprocess.run([*map(str, command)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"bench: {case.feature}: {done.stdout}{done.stderr}")
    with out.open() as file:
        rows = [[float(x) for x in row] for row in list(csv.reader(file))[1:]]
    return rows, json.loads(done.stdout)["report"]


def judged(case: Case) -> tuple[float, tuple[str, ...]]:
    """How far loops are from members written out; the row."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        loops, written = (ran(case, FEW, n, folder)[0] for n in (0, 10**6))
        size = max(abs(x) for row in written for x in row[1 + bool(case.members) :])
        off = max(
            abs(x - y) / size
            for one, other in zip(loops, written, strict=True)
            for x, y in zip(one, other, strict=True)
        )
        report = ran(case, case.many, 0, folder)[1]
    if case.members:  # of steps of Verlet, one evaluation each
        steps = round(case.until / 0.01) * report["members"]
        calls, method = steps, report["method"]
    else:
        calls, method = report["evaluations"], report["method"]
    each = report["seconds"] / calls / case.many * 1e9
    return off, (
        *(case.feature, f"{FEW}", f"{off:.1e}", f"{case.many:,}", method, f"{calls:,}"),
        *(f"{each:.2g}", f"{report['seconds']:.2g}"),
    )


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench families", description=__doc__)
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--only", default="", help="features that have this text")
    options = parser.parse_args(arguments)
    if options.docs and options.only:
        raise SystemExit("bench: the docs have all features")
    found = []
    for case in (case for case in CASES if options.only in case.feature):
        found.append(judged(case))
        print(" | ".join(found[-1][1]), flush=True)
    text = tables.table(HEAD, [row for _, row in found])
    print(text)
    if options.docs:
        write_table(PAGE, "families", text)
    return 4 if any(off > SAME for off, _ in found) else 0
