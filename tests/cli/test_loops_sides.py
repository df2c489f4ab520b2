"""Switches by negative arguments, and sample blocks beside momenta, multipliers and carried values,
in runs of families kept and written out."""

import pytest

from conftest import run_pkgen

HEAD = """model chain
size N = 3
input f
coord q[1..N], X
state w
"""
OWN = "kinetic sum(q[i]'^2/2, i = 1..N) + X'^2/2\npotential sum(q[i]^2/2, i = 1..N) + X^2/2\n"
START = "start q[i = 1..N] = 1/i\nstart X = 0.2\n"
BLOCK = "force q[N] = f\nsample c every 0.2\n  set f = {}\nend\n"
MODELS = {
    "sides": OWN
    + "force X = if(q[N] > 0, q[1], 0)\n"
    + "force q[i = 1..N] = step(-q[i]) - 0.1*if(q[i]' > 0, 1, -1)\n"
    + "rate w = step(-2*q[1]) + if(0 < q[N] and X > 0.1, q[1], 0)\n",
    "while": OWN + "rate w = -w\nobserve o = integral(q[1]) while q[N] > 0\n",
    "momenta": OWN + "rate w = -w\nobserve P = p_q[1]\n" + BLOCK.format("1 - q[N]'"),
    "multipliers": OWN
    + "rate w = -w\nconstraint tie: q[1] = X + q[2] + 0.3\nstart q[2] = 0.5\n"
    + BLOCK.format("lambda_tie/3"),
    "turning": "rotation R[1..N]\nrate w = -w\n"
    + OWN
    + "kinetic sum(omega(R[i]).x^2 + omega(R[i]).y^2 + 2*omega(R[i]).z^2, i = 1..N)\n"
    + "potential sum((R[i]*[1, 2, 0]).x*q[i], i = 1..N)\n"
    + "event low: q[1] falling then omega(R[i = 1..N]) = -0.5*omega(R[i]), q[2] = 1\n"
    + BLOCK.format("1 - omega(R[2]).z"),
    "carried": "let x[0] = 0\nlet x[i = 1..N] = x[i-1] + sin(q[i])\n"
    + OWN
    + "kinetic sum(x[i]'^2/2, i = 1..N)\nrate w = x[N] - w\n"
    + BLOCK.format("1 - q[N]'"),
}


@pytest.mark.parametrize("kind", MODELS)
def test_families_are_members_written_out(kind, tmp_path):
    model = tmp_path / "chain.lag"
    model.write_text(HEAD + MODELS[kind] + START)
    how = ("--until", "3", "--every", "1", "--method", "dop853", "--rtol", "1e-12")
    kept, written = (
        [row.split(",") for row in run_pkgen("run", str(model), way, *how).stdout.splitlines()]
        for way in ("--no-unroll", "--unroll")
    )
    assert sorted(kept[0]) == sorted(written[0]) and len(kept) == len(written) == 5
    for one, other in zip(kept[1:], written[1:], strict=True):
        numbers = dict(zip(written[0], map(float, other), strict=True))
        expected = [numbers[name] for name in kept[0]]
        assert [*map(float, one)] == pytest.approx(expected, rel=1e-8, abs=1e-8)
