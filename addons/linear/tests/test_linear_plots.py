"""Pictures and responses of linear models."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy
import pytest

import pkgen as package
from conftest import ROOT, ran, run_pkgen, written
from pkgen_linear.plots import LinearModel, branches

pytestmark = pytest.mark.needs_addon("linear")

HOOP = ROOT / "models/bead_on_hoop.lag"
SWING = ROOT / "models/controlled/cart_pole_swing_up.lag"


def pair_of_masses(tmp_path: Path) -> LinearModel:
    """Two masses and a third that neither the force nor an output sees."""
    text = "model masses\ncoord x, y, z\ninput u\nkinetic (x'^2 + y'^2 + z'^2)/2\n"
    text += "potential 3*x^2 + (y - x)^2 + 2*z^2\ndissipation 0.1*x'^2 + 0.05*y'^2\n"
    text += "force x = u\nobserve far = y\nobserve near = x\nobserve both = x + u/5\n"
    return package.load(written(tmp_path, text)).linearise()


@pytest.mark.parametrize("period", [0.0, 0.5])
def test_a_bode_diagram_is_the_frequency_response(tmp_path: Path, period: float) -> None:
    signal = pytest.importorskip("scipy.signal")
    found = pair_of_masses(tmp_path)
    found = found.discrete(period) if period else found
    of = {"dt": period} if period else {}
    for name in found.outputs:
        i, _ = found.places(name, "u")
        panels = found.bode(name, "u").axes
        w, size = panels[0].lines[0].get_data()
        phase = panels[1].lines[0].get_ydata()
        system = signal.StateSpace(found.A, found.B, found.C[[i]], found.D[[i]], **of)
        asked = w * period if period else w
        _, dB, degrees = system.bode(asked)
        good = numpy.isfinite(size)
        assert good.sum() > 600 and size[good] == pytest.approx(dB[good], abs=1e-8)
        turns = (phase - degrees)[good] / 360
        assert turns == pytest.approx(numpy.round(turns), abs=1e-9)
        assert w.max() < math.pi / period if period else w.max() > 20


def test_a_root_locus_ends_at_the_zeros(tmp_path: Path) -> None:
    signal = pytest.importorskip("scipy.signal")
    found = pair_of_masses(tmp_path)
    for name, k in product(("near", "both"), (0.0, 0.3, 5.0, -2.0)):
        above, below = found.transfer(name, "u")
        (closed,) = found.closed_poles(name, "u", numpy.array([k]))
        by_hand = numpy.roots(below + k * above)
        assert numpy.sort_complex(closed) == pytest.approx(numpy.sort_complex(by_hand), abs=1e-6)
    # y'' + 0.1 y' + 2 y = 0 holds where x rests: the zeros, and the poles of z beside them.
    zeros = found.zeros("near", "u")
    rest = signal.lti([1], [1, 0.1, 2]).poles
    assert all(min(abs(zeros - z)) < 1e-9 for z in (*rest, 2j, -2j)) and len(zeros) == 4
    # In other states, the zeros at infinity are finite by rounding.
    T = numpy.linalg.qr(numpy.random.default_rng(4).normal(size=(6, 6)))[0]
    turned = replace(found, A=T.T @ found.A @ T, B=T.T @ found.B, C=found.C @ T)
    assert numpy.sort(turned.zeros("far", "u").imag) == pytest.approx([-2, 2])
    assert not replace(found, B=0 * found.B).zeros("far", "u").size
    shuffled = numpy.array([[0, 1, 5j], [5j, 0.1, 1.1], [1.2, 5j, 0.2]])
    assert branches(shuffled).tolist() == [[0, 1, 5j], [0.1, 1.1, 5j], [0.2, 1.2, 5j]]
    axes = found.root_locus("near", "u").axes[0]
    ends = [complex(line.get_xdata()[-1], line.get_ydata()[-1]) for line in axes.lines]
    starts = [complex(line.get_xdata()[0], line.get_ydata()[0]) for line in axes.lines]
    assert all(min(abs(found.poles - z)) < 1e-6 for z in starts)
    assert sum(min(abs(zeros - z)) < 1e-2 for z in ends) == 4
    steps = [abs(numpy.diff(numpy.array(x.get_data()).T, axis=0)).max() for x in axes.lines[:4]]
    assert min(steps) < 0.1
    # u = 4 x makes the stiffness 8 - 4, and y as it is.
    axes = found.root_locus("near", "u", -4).axes[0]
    ends = [complex(line.get_xdata()[-1], line.get_ydata()[-1]) for line in axes.lines]
    (closed,) = found.closed_poles("near", "u", numpy.array([-4.0]))
    assert all(min(abs(closed - z)) < 1e-9 for z in ends)


def test_poles_show_what_no_input_reaches(tmp_path: Path) -> None:
    axes = pair_of_masses(tmp_path).plot_poles().axes[0]
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["6 poles", "2 uncontrollable", "2 unobservable"]
    for marks in axes.collections[1:]:
        assert sorted(numpy.ravel(marks.get_offsets()[:, 1])) == pytest.approx([-2, 2])


def test_python_control_takes_a_linear_model(tmp_path: Path) -> None:
    control = pytest.importorskip("control")
    found = package.load(SWING).linearise("trim", want={"theta": 0})
    system, w = found.to_ss(), numpy.array([0.1, 2.0, 30.0])
    assert control.ctrb(system.A, system.B) == pytest.approx(found.controllability()[1])
    assert control.obsv(system.A, system.C) == pytest.approx(found.observability()[1])
    response = numpy.moveaxis(system(1j * w), -1, 0)
    assert response == pytest.approx(found.frequency_response(w), rel=1e-9)
    weights = numpy.diag([5.0, 20, 1, 1])
    closed = found.A - found.B @ control.lqr(system, weights, [[0.1]])[0]
    assert (numpy.linalg.eigvals(closed).real < 0).all()
    assert control.bode_plot(system) is not None


def test_a_response_at_a_pole_is_not_a_number() -> None:
    found = package.load(SWING).linearise("trim", want={"theta": 0})
    at_rest, beside = found.frequency_response(numpy.array([0.0, 1.0]))
    assert numpy.isnan(at_rest).all() and numpy.isfinite(beside).all()


def test_a_command_draws(tmp_path: Path) -> None:
    words = ("linearise", SWING, "--at", "trim", "--want", "theta=0", "--plot")
    for kind, more in (("bode", ()), ("poles", ()), ("root_locus", ("--transfer", "theta,u"))):
        file = tmp_path / f"{kind}.svg"
        ran(*words, kind, *more, "-o", file)
        assert "<svg" in file.read_text()
    assert "phase" in ran(*words, "bode", "--transfer", "x,u").stdout
    for wrong, said in (
        (("root_locus",), "name an output, of x, theta, x', theta', and an input, of u"),
        (("bode", "--transfer", "x"), "give an output and an input"),
        (("bode", "--transfer", "x,v"), "v: no input; there are u"),
        (("bode", "--json"), "leave --json"),
        (("bode", "-o", "a.txt"), "must end in"),
    ):
        done = run_pkgen(*words, *wrong)
        assert done.returncode == 2 and said in done.stderr + done.stdout
    done = run_pkgen("linearise", HOOP, "--plot", "bode")
    assert done.returncode == 2 and "bode: the model has no input" in done.stderr
    done = run_pkgen("linearise", SWING, "--transfer", "x,u")
    assert done.returncode == 2 and "--plot" in done.stderr
