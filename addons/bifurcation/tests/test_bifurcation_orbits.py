"""Periodic orbits, against closed forms, tables and other methods."""

import math

import numpy
import pytest
from continued import DUFFING, HALO, KEPLER, ROSSLER, THREE, VAN_DER_POL, found, kinds, loaded

from conftest import ROOT
from pkgen import UsageError

# The period of the van der Pol oscillator at mu = 1, by Taylor series of mpmath.
PERIOD = 6.6632868593231301896996820305
ARENSTORF = 17.0652165601579625588917206249


def test_kepler_has_his_third_law(tmp_path) -> None:
    (branch,) = found(KEPLER, tmp_path, "energy", -1.0, -0.3, orbit="start").branches
    for p in branch.points:
        assert abs(p.period - 2 * math.pi * (-2 * p.value) ** -1.5) < 1e-9
        assert abs(p.energy - p.value) < 1e-10 and p.stable
    (branch,) = found(KEPLER, tmp_path, "mu", 0.5, 2.0, orbit="start").branches
    assert (branch.points[0].value, branch.points[-1].value) == pytest.approx((0.5, 2.0))
    for p in branch.points:  # the energy stays -1/2, so a = mu
        assert abs(p.period - 2 * math.pi * p.value) < 1e-9


def test_the_orbit_of_arenstorf(tmp_path) -> None:
    mu = 0.012277471
    made = found(THREE, tmp_path, "mu", mu - 1e-9, mu + 1e-9, scene="arenstorf", orbit="start")
    (branch,) = made.branches
    point = min(branch.points, key=lambda p: abs(p.value - mu))
    assert abs(point.value - mu) < 1e-15 and abs(point.period - ARENSTORF) < 2e-11
    assert not point.stable
    large, small = sorted(map(abs, point.values), reverse=True)
    assert abs(large * small - 1) < 1e-6


@pytest.mark.long
def test_the_figure_eight_is_stable(tmp_path) -> None:
    """Its multipliers are exp(2 pi i nu): C. Simo, in: Celestial Mechanics (AMS, 2002) 209."""
    how = {"scene": "figure_eight", "orbit": "start", "period": 6.32591398292623}
    path = ROOT / "models/particles/n_body.lag"
    (branch,) = found(path, tmp_path, "energy", -1.29, -1.285, **how).branches
    for p in branch.points:
        nu = sorted(abs(numpy.angle(p.values)) / (2 * math.pi))
        assert nu == pytest.approx([0.00842272] * 2 + [0.29809253] * 2, abs=2e-8)
        assert p.stable
        # Similar orbits: the period goes as |energy|^(-3/2).
        first = branch.points[0]
        assert p.period == pytest.approx(first.period * (first.value / p.value) ** 1.5, rel=1e-9)


def test_lyapunov_orbits_begin_at_the_frequency_of_l1(tmp_path) -> None:
    made = found(THREE, tmp_path, "energy", -1.6, -1.55, scene="L1", orbit="centre")
    (branch,) = made.branches
    first = branch.points[0]
    assert first.period == pytest.approx(2 * math.pi / 2.335372627, abs=1e-3)
    assert abs(first.values[0]) == pytest.approx(math.exp(2.9336218 * first.period), rel=2e-3)
    energies = [p.value for p in branch.points]
    assert energies == sorted(energies) and abs(energies[-1] + 1.55) < 1e-9
    at = branch.start(len(branch.points) // 2)
    rows = loaded(THREE, tmp_path).run(
        branch.points[len(branch.points) // 2].period, start=at["start"], method="gauss", rtol=1e-13
    )
    assert abs(rows["x"][-1] - rows["x"][0]) < 1e-7


def test_halo_orbits_have_the_figures_of_howell(tmp_path) -> None:
    """Half the period 1.348532; the stability indices 51.07839 and -0.90203."""
    how = {"orbit": "start", "period": 2 * 1.348532}
    (branch,) = found(HALO, tmp_path, "mu", 0.0399, 0.0401, **how).branches
    point = min(branch.points, key=lambda p: abs(p.value - 0.04))
    assert abs(point.value - 0.04) < 1e-9 and abs(point.period / 2 - 1.348532) < 1e-6
    assert abs(point.state["z"] - 0.215589) < 1e-6
    indices = sorted({round(((z + 1 / z) / 2).real, 3) for z in point.values})
    assert indices == pytest.approx([-0.90203, 51.07839], abs=1e-3)


def test_halo_orbits_leave_the_planar_ones(tmp_path) -> None:
    of = "x = 0.723268, z = 0.04, y' = 0.198019"
    model = HALO.replace("x = 0.729988, z = 0.215589, y' = 0.397259", of)
    made = found(model, tmp_path, "energy", -1.6866, -1.65, orbit="start")
    assert kinds(made) == ["pitchfork"] and len(made.branches) == 2
    (halo,) = [b for b in made.branches if b.begins]
    tall = [p.extents["z"][1] for p in halo.points]
    assert min(tall) < 1e-6 < 0.03 < max(tall)


def _balanced(omega: float, period_start: float, rate: float) -> tuple[float, float, float]:
    """Returns x(0), x'(0) of Duffing's motion by harmonic balance, and the smallest singular value
    of its equations: Fourier series of 40 harmonics, by Newton's method."""
    from scipy.integrate import solve_ivp

    count, T = 128, 2 * math.pi / omega
    k = numpy.fft.fftfreq(count, 1 / count)
    t = T * numpy.arange(count) / count
    eye = numpy.eye(count)

    D = numpy.real(numpy.fft.ifft((1j * omega * k)[:, None] * numpy.fft.fft(eye, axis=0), axis=0))

    def f(time, y):
        return [y[1], -y[0] - y[0] ** 3 - 0.1 * y[1] + 0.5 * math.cos(omega * time)]

    x = solve_ivp(f, (0, T), [period_start, rate], t_eval=t, rtol=1e-8, atol=1e-10).y[0]
    L = D @ D + 0.1 * D + eye
    for _ in range(30):
        slopes = L + numpy.diag(3 * x * x)
        step = numpy.linalg.lstsq(slopes, L @ x + x**3 - 0.5 * numpy.cos(omega * t), rcond=1e-9)[0]
        x = x - step
        if abs(step).max() < 1e-12:
            break
    return x[0], (D @ x)[0], numpy.linalg.svd(slopes, compute_uv=False)[-1]


def test_the_resonance_of_duffing_by_harmonic_balance(tmp_path) -> None:
    made = found(DUFFING, tmp_path, "omega", 0.5, 3.0, orbit="start", period="T")
    (branch,) = made.branches
    assert kinds(made) == ["fold", "fold"]
    high, low = (p.value for p in branch.special)
    assert (high, low) == pytest.approx((2.2119353170, 1.4386701455), abs=1e-8)
    for point in branch.points[::12]:
        if not point.kind:
            x, v, _ = _balanced(point.value, point.state["x"], point.state["x'"])
            assert (x, v) == pytest.approx((point.state["x"], point.state["x'"]), abs=1e-8)
    for point in branch.special:
        assert _balanced(point.value, point.state["x"], point.state["x'"])[2] < 1e-5
    for point in branch.points:  # det M = exp(-delta T)
        assert numpy.prod(point.values).real == pytest.approx(
            math.exp(-0.1 * point.period), rel=1e-8
        )
        if not point.kind:
            assert point.stable == all(abs(z) < 1 for z in point.values)


def test_orbits_begin_at_hopf_and_have_the_period_of_van_der_pol(tmp_path) -> None:
    made = found(VAN_DER_POL, tmp_path, "mu", -1.0, 1.0, orbit="hopf")
    (orbits,) = [b for b in made.branches if b.kind == "orbits"]
    assert orbits.begins == "hopf" and orbits.points[-1].stable
    assert abs(orbits.points[0].period - 2 * math.pi) < 1e-9
    assert abs(orbits.points[-1].period - PERIOD) < 1e-10
    small = orbits.points[1]  # x = 2 sqrt(mu) cos t
    assert small.extents["x"][1] == pytest.approx(2 * math.sqrt(small.value), rel=1e-3)


def test_the_doublings_of_rossler(tmp_path) -> None:
    """The multiplier at a doubling is -1 by the variational equations, too."""
    from scipy.integrate import solve_ivp

    made = found(ROSSLER, tmp_path, "c", 2.5, 4.0, orbit="start")
    doublings = [p for p in made.special if p.kind == "period doubling"]
    assert [p.value for p in doublings] == pytest.approx([2.832445, 3.837358], abs=1e-6)
    assert [b.begins for b in made.branches] == ["", *["period doubling"] * 2]

    def f(_, y, c):
        (x, y_, z), M = y[:3], y[3:].reshape(3, 3)
        A = numpy.array([[0, -1, -1], [1, 0.2, 0], [z, 0, x - c]])
        return [-y_ - z, x + 0.2 * y_, 0.2 + z * (x - c), *(A @ M).ravel()]

    for p in doublings:
        begun = [*p.state.values(), *numpy.eye(3).ravel()]
        end = solve_ivp(f, (0, p.period), begun, args=(p.value,), rtol=1e-11, atol=1e-12).y[:, -1]
        assert abs(end[:3] - begun[:3]).max() < 1e-8
        values = numpy.linalg.eigvals(end[3:].reshape(3, 3))
        assert abs(values + 1).min() < 1e-6


def test_pendulums_that_turn_over(tmp_path) -> None:
    """An orbit may close but for a turn: the period is 2 K(1/k)/k, k^2 = (E + 1)/2."""
    from scipy.special import ellipk

    model = "model p\ncoord a [rad]\nkinetic a'^2/2*(1 [kg*m^2])\npotential -cos(a)*(1 [J])\n"
    made = found(model + "start a' = 2.5\n", tmp_path, "energy", 1.5, 4.0, orbit="start")
    for p in made.branches[0].points:
        k = math.sqrt((p.value + 1) / 2)
        assert p.period == pytest.approx(2 * ellipk(1 / k**2) / k, rel=1e-9)


@pytest.mark.parametrize(
    ("model", "free", "more", "said"),
    [
        (DUFFING, ("omega", 0.5, 1.0), {}, "period"),
        (DUFFING, ("omega", 0.5, 1.0), {"period": 3.0}, "do not have the period 3"),
        (VAN_DER_POL, ("mu", -0.9, -0.5), {}, "no periodic orbit|does not come back"),
        (VAN_DER_POL, ("energy", 0.1, 1.0), {}, "not proved that the energy is constant"),
        (KEPLER, ("energy", -0.4, -0.3), {}, "which FROM:TO is to contain|has -0.5"),
        (KEPLER, ("e", 0.5, 0.7), {"start": {"x": 1, "y": 0, "x'": 1, "y'": 0}}, "orbit|motion"),
    ],
)
def test_orbits_that_are_not_there_are_refused(model, free, more, said, tmp_path) -> None:
    name, low, high = free
    with pytest.raises(UsageError, match=said):
        found(model, tmp_path, name, low, high, orbit="start", **more)
