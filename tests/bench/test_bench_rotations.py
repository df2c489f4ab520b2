"""What `python -m bench rotations` compares: one motion in all its forms, and how it is shown."""

import math
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest

from bench import attitudes, report, rotation_cases, rotation_drift, rotations
from bench.contender import Contender
from bench.measure import QUICK, Comparison, Track
from bench.peers import forms

ANGLES, RATES = (0.7, 1.1, -2.3), (0.4, -0.9, 1.7)


def turn(axis: int, angle: float) -> np.ndarray:
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found = np.eye(3)
    found[i, i] = found[j, j] = math.cos(angle)
    found[j, i], found[i, j] = math.sin(angle), -math.sin(angle)
    return found


def euler(angles) -> np.ndarray:
    phi, theta, psi = angles
    return turn(2, phi) @ turn(0, theta) @ turn(2, psi)


def test_a_quaternion_turns_as_its_angles_do() -> None:
    found = np.array(attitudes.matrix(attitudes.quaternion(*ANGLES))).reshape(3, 3)
    assert abs(found - euler(ANGLES)).max() < 1e-15
    assert abs(found - euler(ANGLES).T).max() > 0.1


def test_body_rates_are_those_of_the_matrix() -> None:
    h = 1e-6
    later, before = (euler(np.add(ANGLES, np.multiply(s * h, RATES))) for s in (1, -1))
    hat = euler(ANGLES).T @ (later - before) / (2 * h)
    found = attitudes.body_rates(ANGLES, RATES)
    assert np.allclose(found, (hat[2, 1], hat[0, 2], hat[1, 0]), atol=1e-8)


@pytest.mark.parametrize("make", rotation_cases.CASES)
def test_forms_have_the_same_start(make) -> None:
    case = make()
    for start in case.starts(2):
        first, *others = (f.seen(f.given(start)) for f in case.forms)
        assert np.allclose(case.seen(case.given(start)), first, atol=1e-14)
        for other in others:
            assert np.allclose(first, other, atol=1e-14)
    assert not np.allclose(*(case.forms[0].seen(list(s)) for s in case.starts(2)), atol=1e-3)


@pytest.mark.parametrize("make", rotation_cases.CASES)
def test_forms_have_the_same_end(make) -> None:
    """That of the equations by hand; a loose tolerance misses it."""
    case = make()
    (exact,) = rotations.exact(case, 1)
    for form in case.forms:
        session = forms.opened(form, "gauss", case, ())[0]
        tight, loose = (
            session.integrate(setting, case.start, case.t_end, 0)[1] for setting in (1e-14, 1e-3)
        )
        session.close()
        assert np.allclose(tight, exact, atol=1e-11), form.name
        assert not np.allclose(loose, exact, atol=1e-11), form.name
        assert min(session.took[1e-3]) > 5
        assert session.took[1e-14] > session.took[1e-3]


def test_the_free_body_by_hand_is_that_of_jacobi() -> None:
    """From w = (1, 0, 1.2), I = (1, 2, 3), it is (cn, sn, 1.2 dn)(1.2 t, k), k^2 = 1/4.32."""
    case = rotation_cases.free_body()
    (exact,) = rotations.exact(case, 1)
    u, m = 1.2 * case.t_end, 1 / 4.32
    cn, sn, dn = (float(mpmath.ellipfun(f, u, m=m)) for f in ("cn", "sn", "dn"))
    assert np.allclose(exact[9:], (cn, sn, 1.2 * dn), atol=1e-14)
    assert abs(exact[10]) > 0.1


def track(name: str, each: float, rounds: int, fixed: bool = False) -> Track:
    """Of order 4: errors 1e-4, 1e-8, 1e-12 in 10, 100, 1000 steps."""
    settings = [1e-4, 1e-8, 1e-12]
    took = {s: (s**-0.25, 8 * s**-0.25) for s in settings}
    session = SimpleNamespace(took=took, flags="")
    contender = Contender(name, "pkgen", fixed, lambda m, b: [])
    seconds = [[[each * s**-0.25] for s in settings] for _ in range(rounds)]
    return Track(contender, session, settings, {}, [[s] for s in settings], seconds)


def test_costs_and_ratios_at_an_error() -> None:
    tracks = [track("angles: gauss", 1e-6, 3), track("rotation: slow", 9e-6, 3)]
    tracks += [track("rotation: gauss", 2e-6, 3), track("by hand: heyoka", 5e-6, 2)]
    found = Comparison(None, tracks, {})
    assert rotations.cost(tracks[0], 1e-6) == "31.6 (32, 253)"
    assert rotations.cost(tracks[0], 1e-2) == "≤ 10 (10, 80)"
    assert rotations.cost(tracks[0], 1e-13) == "-"
    lines = rotations.ratios(found).splitlines()[2:]
    assert [line.split(" | ")[0].strip("| ") for line in lines] == [
        "angles / rotation",
        "by hand: heyoka / rotation",
    ]
    assert "0.5 [0.5, 0.5] gauss, gauss" in lines[0]
    assert "2.5 [2.5, 2.5] heyoka, gauss" in lines[1]


def test_the_order_is_that_of_errors_beyond_rounding() -> None:
    found = track("rotation: rkmk4", 1e-6, 1, fixed=True)
    found.settings = [0.4, 0.2, 0.1, 0.05, 0.025]
    found.errors = [[x, 3 * x] for x in (0.5, 3e-3, 2e-4, 1.25e-5, 1e-14)]
    assert rotations.order(found) == "4.0"
    found.errors[1] = [4e-4, 4e-4]  # 1 before 4: not yet
    assert rotations.order(found) == "-"
    found.errors[1:4] = [[3e-3, 3e-3], [2e-13, 2e-13], [1e-14, 1e-14]]
    assert rotations.order(found) == "-"
    assert rotations.order(track("rotation: gauss", 1e-6, 1)) == ""


def test_what_is_kept_of_a_body_is_told_from_what_is_not() -> None:
    case = rotation_cases.free_body()
    start = attitudes.angles_to_quaternion(case.start)
    still = np.array([start, start])
    assert max(rotation_drift.kept(case, still)) < 1e-15
    longer, turned, faster = still.copy(), still.copy(), still.copy()
    longer[1, :4] *= 1 + 1e-6
    turned[1, :4] = attitudes.quaternion(1e-6, *case.start[1:3])
    faster[1, 4:] *= 1 + 1e-6
    assert rotation_drift.kept(case, longer)[2] == pytest.approx(1e-6, rel=1e-3)
    energy, momentum, length = rotation_drift.kept(case, faster)
    assert energy == pytest.approx(2e-6, rel=1e-3) and momentum == pytest.approx(1e-6, rel=1e-3)
    assert length < 1e-15
    # About the momentum itself nothing changes; it is the top's vertical part that is kept.
    assert rotation_drift.kept(case, turned)[1] < 1e-15
    turned[1, :4] = attitudes.quaternion(0, case.start[1] + 1e-6, case.start[2])
    assert rotation_drift.kept(case, turned)[1] > 1e-8


def test_each_command_leaves_what_the_other_wrote(tmp_path, monkeypatch) -> None:
    page = tmp_path / "docs" / "benchmarks.md"
    page.parent.mkdir()
    page.write_text("# Old\n\nfigures\n")
    monkeypatch.setattr(report, "PAGE", page)
    here = SimpleNamespace(lines=lambda: ["here"])
    report.write_block("rotations", "## Rotations\n\nfirst\n")
    turned = f"{report.MARK.format('rotations')}\n## Rotations\n\nfirst\n"
    assert page.read_text() == f"# Old\n\nfigures\n\n{turned}"
    report.write_docs({"Figures to reach": "new"}, here, QUICK)
    text = page.read_text()
    assert "figures\n\n" not in text and "## Figures to reach\n\nnew\n" in text
    assert text.endswith(f"\n\n{turned}")
    report.write_block("arms", "## Arms\n\nthird\n")
    armed = f"\n{report.MARK.format('arms')}\n## Arms\n\nthird\n"
    assert page.read_text() == text + armed
    report.write_block("rotations", "## Rotations\n\nsecond\n")
    assert page.read_text() == (text + armed).replace("first", "second")
