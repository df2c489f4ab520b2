"""What a reviewer found in families as loops, once each."""

import ctypes
import math
import random

import pytest
from loop_harness import Looped, Written, looped
from test_loops import METHODS, assert_kernels, fused, one_by_one

from conftest import run_pkgen
from pkgen.__main__ import main
from pkgen.source import ModelError

CHAIN = """\
size N = 4
coord {q}[1..N]
fixed {q}[0] = 0, {q}[N+1] = 0
kinetic sum({q}[i]'^2/2, i = 1..N)
"""


@pytest.mark.parametrize("amplitude", [1e-2, 1e-5, 1e-8])
def test_near_rest_the_acceleration_keeps_its_digits(amplitude, tmp_path):
    """(1 - exp(-d))^3 must not be expanded: of M = 1 the force is the same, kernel by kernel."""
    bond = "1-exp(-(q[i+1]-q[i]))"
    text = f"model anharmonic\nparam a = 0.25\nparam b = 0.7\n{CHAIN.format(q='q')}"
    text += f"potential sum(a/3*({bond})^3 + b/4*({bond})^4, i = 0..N)\n"
    at = Looped(text, tmp_path).at(40)
    q = [amplitude * ((7 * i) % 5 - 2) for i in range(40)]
    _, (a,) = at.call("acceleration", 0.0, q, [0.0] * 40, [], (40,), ctypes.c_int)
    _, (f,) = at.call("force", 0.0, q, [0.0] * 40, [], (40,))
    scale = max(map(abs, f))
    # exp() itself is rounded: 1 - exp(-d) to eps/d.
    allowed = 20 * 2.2e-16 / amplitude
    assert scale > 0 and max(abs(x - y) for x, y in zip(a, f, strict=True)) < allowed * scale


@pytest.mark.parametrize("name", ["flux", "total", "own"])
def test_names_of_the_emitted_code_are_free(name, tmp_path):
    bonds = f"potential sum(({name}[i+1]-{name}[i])^2/2, i = 0..N)\n"
    pairs = f"potential sum(sum(cos({name}[i]-{name}[j]), j = i+1..N), i = 1..N)\n"
    Looped(f"model bonds\n{CHAIN.format(q=name)}{bonds}", tmp_path)
    Looped(f"model pairs\n{CHAIN.format(q=name)}{pairs}", tmp_path)
    scalar = f"coord {name}\n{CHAIN.format(q='q').rstrip()} + {name}'^2/2\n"
    Looped(f"model scalar\n{scalar}potential sum(q[i]*{name}, i = 1..N)\n", tmp_path)


@pytest.mark.parametrize(
    ("potential", "wrong"),
    [
        ("1e200*sum(1e200*q[i]^2, i = 1..N)", "too large"),
        ("1e-200*sum(1e-200*q[i]^2, i = 1..N)", "too small"),
        ("sum(q[i]^2, i = 1..N)/(1e200)/1e200", "too small"),
    ],
)
def test_a_constant_that_no_double_holds_is_refused(potential, wrong):
    with pytest.raises(ModelError) as refused:
        looped(f"model scaled\n{CHAIN.format(q='q')}potential {potential}\n")
    assert wrong in refused.value.diagnostics[0].message


def test_a_double_sum_that_says_nothing_of_its_pair_adds_no_force(tmp_path):
    """Its derivatives vanish: C got an array of no entries."""
    text = f"model idle\n{CHAIN.format(q='q')}potential sum((q[i]-q[i])^2, i = 1..N, j = 1..N)\n"
    Looped(text, tmp_path)


def test_a_given_end_has_its_rate_in_sums_that_end_on_it(tmp_path):
    """h = T2 - T0 + V, and T0 is the end's: it was at rest unless a neighbour looked there."""
    end = "coord q[1..N]\nfixed q[0] = 0, q[N+1] = 0.2*sin(t)\n"
    text = f"model driven\nsize N = 4\n{end}kinetic sum(q[i]'^2/2, i = 0..N+1)\n"
    at = Looped(text, tmp_path).at(4)
    energy, _ = at.call("energy", 0.3, [0.0] * 4, [0.5] * 4, [], (), ctypes.c_double)
    assert energy == pytest.approx(0.5 - (0.2 * math.cos(0.3)) ** 2 / 2, rel=1e-14)


def test_pivots_of_a_diagonal_mass_are_watched_whatever_kernels_there_are(tmp_path):
    """C called a kernel that it had not."""
    text = "model thin\nsize N = 20\ncoord q[1..N]\npotential sum(q[i]^2, i = 1..N)\n"
    text += "kinetic sum((3 + i/N - 2*cos(i))*q[i]'^2/2, i = 1..N)\n"
    model = tmp_path / "thin.lag"
    model.write_text(text)
    assert main(["run", str(model), "--until", "0.1", "--method", "rk4", "--step", "0.1"]) == 0


HEAD = "size N = 31\ncoord q[1..N]\nkinetic sum(q[i]'^2/2, i = 1..N)\n"
ALONE = "potential sum(q[i]^2/2, i = 1..N)\n"


@pytest.mark.parametrize(
    "text",
    [
        ALONE,
        ALONE + "size K = 25\ncoord r[1..K]\nkinetic sum(r[i]'^2/2, i = 1..K)\n",
        ALONE + "let y[0] = 0\nlet y[i = 1..N] = y[i-1] + q[i]\nobserve z = y[N]\n",
    ],
    ids=["alone", "unequal", "along"],
)
def test_members_that_feel_no_others_compile(text, tmp_path):
    """A run compiles few kernels, and headers for these alone."""
    scene = "start q[1] = 1\nscene a\nuntil 1\nmethod verlet step 0.01\nrecord q[1] every 1\nend\n"
    (tmp_path / "alone.lag").write_text(f"model alone\n{HEAD}{text}{scene}")
    done = run_pkgen("run", tmp_path / "alone.lag", "--scene", "a")
    assert float(done.stdout.split(",")[-1]) == pytest.approx(math.cos(1), abs=1e-4)


def test_a_free_end_of_the_shorter_of_two_families_reads_what_has_not_drifted(tmp_path):
    text = f"model two\n{HEAD}size K = 2000\ncoord r[1..K]\nfree q[N+1]\n"
    text += "kinetic sum(r[i]'^2/2, i = 1..K)\npotential sum(r[i]^2/2, i = 1..K)\n"
    text += "potential sum((q[i+1] - 2*q[i] + q[i-1])^4, i = 2..N)\n"
    loops, (kick, drift) = Looped(text, tmp_path), METHODS["verlet"]
    for size in (489, 513, 1025):
        at, r = loops.at(size), random.Random(size)
        q, v = ([r.uniform(-1, 1) for _ in range(at.n)] for _ in range(2))
        expected = one_by_one(at, kick, drift, 0.0, 0.01, 4, q, v)
        for one, other in zip(expected, fused(at, kick, drift, 0.0, 0.01, 4, q, v), strict=True):
            assert max(abs(x - y) for x, y in zip(one, other, strict=True)) < 1e-11


def test_many_entries_of_m_that_are_equal_count_once(tmp_path):
    rates = " + ".join(f"q[i+{k}]'" for k in range(15))
    text = f"model dup\n{HEAD}kinetic sum(({rates})^2/2, i = 1..N-14)\n{ALONE}"
    unrolled, at = Written(text, 20, tmp_path / "unrolled"), Looped(text, tmp_path).at(20)
    r = random.Random(1)
    state = 0.0, [r.uniform(-1, 1) for _ in range(20)], [r.uniform(-1, 1) for _ in range(20)], []
    assert_kernels(unrolled, at, state, "dup")
