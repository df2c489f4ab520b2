"""Motions of families kept as loops on constraints: beside the same model with its members written
out, by residuals, and where they are refused or end."""

from __future__ import annotations

import pytest
from test_loops_features import both  # noqa: F401  a fixture

ROPE = """\
model rope
size N = {size}
param l = 1/N in (0, inf)
param a = {angle}
param b = 0.3
param R = l/(2*sin(b/2))  # it lies on an arc
coord x[1..N], y[1..N], z
{ends}
kinetic sum(l*(x[i]'^2 + y[i]'^2)/2, i = 1..N) + z'^2{inertia}
potential sum(l*9.81*y[i], i = 1..N) + z^2{spring}
{rows}
start x[i = 1..N] = R*(sin(a + i*b) - sin(a)), y[i = 1..N] = R*(cos(a + i*b) - cos(a))
start x[N]' = sin(a + (N - 1/2)*b), y[N]' = cos(a + (N - 1/2)*b){more}
observe pull = lambda_rod[N]*l
"""
RODS = "constraint rod[i = {first}..N]: (x[i] - x[i-1])^2 + (y[i] - y[i-1])^2 = l^2"
PINNED = "fixed x[0] = 0, y[0] = 0"
# Ends and rows.
CASES = {
    "hanging": (PINNED, RODS.format(first=1)),
    "swung": ("fixed x[0] = sin(t)^2/9, y[0] = t^2", RODS.format(first=1)),
    "tied": ("", f"constraint held: x[1]^2 + y[1]^2 = l^2\n{RODS.format(first=2)}"),
    "carried": (
        "",
        f"constraint held: (x[1] - z)^2 + y[1]^2 = l^2\n{RODS.format(first=2)}",
    ),
    "led": (
        PINNED,
        RODS.format(first=1) + "\nrolling slip: z' = x[1]'*cos(z) - sum(y[i]', i = 1..N)/N",
    ),
    "ended": ("fixed x[0] = 0, y[0] = 0\nfree x[N+1], y[N+1]", RODS.format(first=1)),
}
METHODS = (
    (("dop853", "--rtol", "1e-12"), 1e-8),
    (("rk4", "--step", "0.001"), 1e-11),
    (("gauss", "--rtol", "1e-12"), 1e-8),
    (("gsl_rk8pd", "--rtol", "1e-11"), 1e-7),
)
ALL = [(name, size) for name in CASES for size in (2, 3, 20)]


@pytest.mark.parametrize("case", ALL)
def test_rods_of_loops_are_those_written_out(case: tuple[str, int], both) -> None:  # noqa: F811
    name, size = case
    ends, tied = CASES[name]
    inertia = " + sum(l*x[i]'*x[i-1]'/5, i = 2..N)" if size == 3 else ""
    spring = " + sum(l*x[i]*y[i], i = 1..N)" if size == 20 else ""
    more = ", z' = -cos(a + (N - 1/2)*b)/N" if name == "led" else ""
    start = {"angle": 0.4 + 0.1 * (size % 3), "inertia": inertia, "spring": spring, "more": more}
    text = ROPE.format(size=size, ends=ends, rows=tied, **start)
    words, tolerance = METHODS[(size + len(name)) % len(METHODS)]
    common = ("--until", 0.3, "--every", 0.1, "--method", *words)
    (loops, _), (flat, _) = both(text, *common)
    assert len(loops) == len(flat) == 4
    for one, other in zip(loops, flat, strict=True):
        assert one == pytest.approx(other, rel=tolerance, abs=tolerance), text
    assert abs(loops[-1][1] - loops[0][1]) > 1e-4
    if name not in ("swung", "led"):
        assert loops[-1][-1] == pytest.approx(loops[0][-1], rel=1e-6)
