"""Momenta of members and of what stands beside them, in outputs and events of families kept as
loops: beside members written out."""

from __future__ import annotations

import pytest
from test_loops_features import both  # noqa: F401 (a fixture)

HEAD = "model momenta\nsize N = 6\nparam m[i = 1..N] = 1 + 0.1*i in (0, inf)\ncoord q[1..N], X\n"
OUTPUTS = """\
observe a = 2*p_q[2] + p_q[N]*q[3]
observe b = sum(p_q[i]*q[i]', i = 1..N) + p_X*X'
observe e[i = 1..N-1] = p_q[i] - p_q[i+1]
event z: p_q[3] - sin(3*t) either
start q[i = 1..N] = 0.1*i, q[i = 1..N]' = 0.2
"""
INERTIA = "kinetic sum(m[i]/2*q[i]'^2*(2 + cos(q[i])) {more}, i = 1..N) + X'^2\n"
SPRINGS = "potential sum((q[i] - q[i-1])^2, i = 2..N)\n"
MODELS = {
    "diagonal": INERTIA.format(more="") + SPRINGS,
    "driven": "fixed q[0] = sin(t)\n" + INERTIA.format(more="+ q[i-1]'*sin(q[i])/9") + SPRINGS,
    "banded": INERTIA.format(more="+ q[i]'*X'/9") + SPRINGS + "state s\nrate s = X - s\n",
    "tied": "coord w[1..N]\nkinetic sum(w[i]'^2, i = 1..N)\ninput pull\n"
    + INERTIA.format(more="+ q[i]'*X'/9")
    + SPRINGS
    + "constraint tie[i = 1..N]: w[i] = q[i]/2 + pull\nstart w[i = 1..N] = 0.05*i\n"
    + "start w[i = 1..N]' = 0.1\n",
    "chain": "let x[0] = X\nlet y[0] = 0\nlet x[i = 1..N] = x[i-1] + sin(q[i])\n"
    "let y[i = 1..N] = y[i-1] - cos(q[i])\n"
    "kinetic sum(m[i]*(x[i]'^2 + y[i]'^2)/2, i = 1..N) + X'^2\n"
    "potential sum(m[i]*9.81*y[i], i = 1..N)\nconserve P = p_X\n",
    "spins": "rotation R[1..N]\nkinetic sum(dot(omega(R[i]), [1, 2, 3])^2/5, i = 1..N)\n"
    "kinetic sum(dot(omega(R[i]), omega(R[i])) + omega(R[i]).x*X'/9, i = 1..N)\n"
    + INERTIA.format(more="")
    + SPRINGS
    + "start omega(R[i = 1..N]) = [0.1*i, 0.2, 0.3]\n"
    "observe r = p_R[2].x + sum(dot(p_R[i], omega(R[i])), i = 1..N)\n",
}


@pytest.mark.parametrize("size", [3, 6])
@pytest.mark.parametrize("name", MODELS)
def test_momenta_are_those_of_members_written_out(name: str, size: int, both) -> None:  # noqa: F811
    text = HEAD.replace("6", f"{size}") + MODELS[name] + OUTPUTS
    words = ("--until", 0.4, "--every", 0.2, "--method", "rk4", "--step", 0.02)
    (loops, told), (written, said) = both(text, *words)
    assert len(loops) == len(written) == 3
    for one, other in zip(loops, written, strict=True):
        assert sorted(one) == pytest.approx(sorted(other), rel=1e-12, abs=1e-12), text
    [event], [expected] = told["events"], said["events"]
    assert event["times"] == pytest.approx(expected["times"], abs=1e-9)
    assert expected["times"]
