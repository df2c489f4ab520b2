"""`accuracy` where the motion is linear, chaotic, or ends: what is promised and what is said."""

from __future__ import annotations

import math

from test_accuracy import run

from conftest import case, run_pkgen

LINEAR = case("damped")
PAIR = case("pair")
ENDS = case("ends")
CHAOS = case("tangle")
PULSE = case("pulse")


def test_a_pulse_that_steps_leap_over_is_seen_and_kept(tmp_path) -> None:
    said, rows, messages = run(tmp_path, PULSE, "s")
    assert said["accuracy"]["horizon"] is None and "warning" not in messages
    assert 0 < said["accuracy"]["expected"] <= 1e-8
    kick = 3 * math.sqrt(math.pi / 10000) * math.exp(-1 / 40000)
    largest = max(abs(x) for _, x in rows)
    for t, x in rows:
        swing = 0.1 * math.cos(t) + (kick * math.sin(t - 55.3) if t > 55.3 else 0.0)
        assert abs(x - swing) <= 1e-8 * largest


def test_a_linear_motion_is_made_by_its_exponential(tmp_path) -> None:
    said, rows, messages = run(tmp_path, LINEAR, "s")
    damping, w = 0.05, math.sqrt(1.69 - 0.05**2)
    for t, q, _ in rows:
        exact = math.exp(-damping * t) * (math.cos(w * t) + damping / w * math.sin(w * t))
        assert abs(q - exact) < 1e-10
    assert said["accuracy"]["method"] == "exponential" and said["settings"]["step"] == 1.0
    # What is recorded beside it is zero, made of errors: promised is what can be.
    assert said["accuracy"]["reference"]["left_out"] == ["none"]
    assert "none: zero but for errors of round-off" in messages
    assert said["accuracy"]["horizon"] is None


def test_linear_motions_are_judged_by_their_exponential(tmp_path) -> None:
    said, rows, messages = run(tmp_path, PAIR, "s")
    found = said["accuracy"]
    assert found["method"] == found["reference"]["method"] == "exponential"
    assert found["horizon"] is None and "warning" not in messages
    assert 1e-16 < found["expected"] < 2e-15
    _, other, _ = run(tmp_path, PAIR, "s", "--method", "dop853", "--rtol", "1e-13")
    for i in (1, 2):
        apart = [abs(mine[i] - its[i]) for mine, its in zip(rows, other, strict=True)]
        assert 0 < max(apart) < 1e-10


def test_a_motion_that_ends_has_its_true_cause_alone(tmp_path) -> None:
    path, rows = tmp_path / "model.lag", tmp_path / "rows.csv"
    path.write_text(ENDS)
    done = run_pkgen("run", path, "--scene", "s", "-o", rows)
    assert done.returncode == 4 and "last valid time 0.927037" in done.stderr
    assert "accuracy 1e-08 is not promised: no method arrives" in done.stderr
    kept = rows.with_name("rows.csv.partial").read_text()
    assert "holds until" not in done.stderr and len(kept.splitlines()) == 11


def test_chaos_warns_with_its_horizon(tmp_path) -> None:
    said, rows, messages = run(tmp_path, CHAOS, "s")
    horizon = said["accuracy"]["horizon"]
    assert f"warning: accuracy 1e-08 holds until t = {horizon:g}" in messages
    assert 10 < horizon < 40 and rows[-1][0] == 60
    # A method that has no part in the run that was chosen leaves it behind the horizon alone.
    assert said["accuracy"]["method"] == "gauss"
    _, other, note = run(tmp_path, CHAOS, "s", "--method", "gauss8", "--step", "0.005")
    assert "the scene's accuracy is not promised: --method" in note
    apart = [abs(x[1] - y[1]) for x, y in zip(rows, other, strict=True)]
    assert max(apart[: int(10 * horizon) - 20]) < 1e-6 < 1e-2 < max(apart)
