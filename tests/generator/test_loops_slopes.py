"""Bands of derivatives of families kept as loops: against the dense ones of the unrolled code."""

import ctypes
import random

import numpy as np
import pytest
from loop_harness import Looped, Written
from loop_models import MODELS, STATES
from rotation_models import made
from test_loops_bound import model as bound
from total_models import HUB, MEAN, RATED, RATES, SWELLING

from conftest import case, seeds
from pkgen.graph.graph import TooLarge
from pkgen.source import ModelError

DENSE = ("gravity", "spin", "field")  # a sum over all members: no bands
# Families of other lengths beside a ring; a free end beside a member of another family there.
UNEVEN = {
    "uneven": (
        case("uneven"),
        (2, 3, 5),
    ),
    "beside": (
        case("beside"),
        (1, 2, 5),
    ),
}
CASES = {**MODELS, **STATES, **UNEVEN}


def matrices(at, kernel: str, state, count: int) -> tuple[list[int], list[np.ndarray]]:
    """The coordinate of each place, and matrices by places, of the pattern of struct pk_pattern."""
    sizes = [ctypes.c_size_t() for _ in range(3)]
    params = ctypes.byref(at.params)
    at.of.function("slopes_pattern")(params, *map(ctypes.byref, sizes))
    rows, width, border = (x.value for x in sizes)
    across, size = 2 * width + 1, rows * (2 * width + 1) + (2 * rows + border) * border
    place_of = at.of.function("slopes_place", ctypes.c_ssize_t)
    place = [place_of(params, ctypes.c_size_t(i)) for i in range(rows + border)]
    assert sorted(p for p in place if p >= 0) == list(range(at.n))
    _, found = at.call(kernel, *state, (size,) * count)
    result = []
    for matrix in found:
        entries = {(i, i + k - width): i * across + k for i in range(rows) for k in range(across)}
        start = rows * across
        for i in range(rows):
            for c in range(border):
                entries[i, rows + c] = start + i * border + c
                entries[rows + c, i] = start + (rows + i) * border + c
        start += 2 * rows * border
        for c in range(border):
            entries |= {(rows + c, rows + d): start + c * border + d for d in range(border)}
        whole = np.zeros((rows + border, rows + border))
        for (i, j), x in entries.items():
            if 0 <= j < rows + border:
                whole[i, j] = matrix[x]
            else:
                assert matrix[x] == 0
        result.append(whole)
    return place, result


def dense(at, kernel: str, state, count: int) -> list[list[float]]:
    """The same by coordinates, row after row, where all places are of coordinates or empty."""
    place, found = matrices(at, kernel, state, count)
    own, none = np.array(place) >= 0, np.array(place) < 0
    order = np.argsort(np.array(place)[own])
    result = []
    for matrix in found:
        assert not matrix[np.ix_(own, none)].any() and not matrix[np.ix_(none, own)].any()
        rest = matrix[np.ix_(none, none)]
        assert (rest == np.eye(len(rest)) * (kernel == "slopes_mass")).all()
        result.append(matrix[np.ix_(own, own)][np.ix_(order, order)].ravel().tolist())
    return result


@pytest.mark.parametrize("name", [name for name in CASES if name not in (*DENSE, "links")])
def test_bands_of_derivatives_are_those_of_the_unrolled_code(name: str, tmp_path) -> None:
    text, sizes = CASES[name]
    loops = Looped(text, tmp_path / "loops")
    largest = [0.0] * 4
    for size in (n for n in sizes if n <= 15):
        unrolled = Written(text, size, tmp_path / f"n{size}")
        at = loops.at(size)
        dice = random.Random(size)
        inputs = len(unrolled.program.equations.inputs)
        for _ in range(3):
            state = (
                dice.uniform(0, 3),
                *([dice.uniform(-1, 1) for _ in range(n)] for n in (at.n, at.n, inputs)),
            )
            found = [*dense(at, "slopes_mass", state, 1), *dense(at, "slopes_jacobian", state, 3)]
            expected = [*unrolled.call("mass", *state)[1], *unrolled.call("jacobian", *state)[1]]
            for k, (one, other) in enumerate(zip(found, expected, strict=True)):
                largest[k] = max(largest[k], *map(abs, other))
                assert one == pytest.approx(other, rel=2e-13, abs=2e-13), f"{name} N = {size}, {k}"
    assert largest[0] > 0 and largest[2] + largest[3] > 0


@pytest.mark.parametrize("name", DENSE)
def test_sums_over_all_members_have_no_bands(name: str, tmp_path) -> None:
    loops = Looped(MODELS[name][0], tmp_path)
    assert not hasattr(loops.library, f"{name}_slopes_pattern")
    assert hasattr(loops.library, f"{name}_force")


def closed(found: tuple[list[int], list[np.ndarray]], more: list[np.ndarray], h, k) -> np.ndarray:
    """Newton's matrix of one stage with the unknowns that are no coordinates eliminated."""
    place, (M,) = found
    p_q, pdot_q, pdot_v = more
    whole = M + h * p_q - k * pdot_v - h * k * pdot_q
    own = np.array([i for i, p in sorted(enumerate(place), key=lambda x: x[1]) if p >= 0])
    rest = np.array([i for i, p in enumerate(place) if p < 0])
    inner = np.linalg.solve(whole[np.ix_(rest, rest)], whole[np.ix_(rest, own)])
    return whole[np.ix_(own, own)] - whole[np.ix_(own, rest)] @ inner


def order(unrolled, at, size: int) -> list[int]:
    """The place, among members written out, of each coordinate of loops: of rotations one is
    behind the other there."""
    names = []
    for g in at.of.equations.coordinates:
        for i in range(1, size + 1) if g.is_family else [0]:
            inside = g.shown.replace("R", f"R[{i}]") if "R" in g.shown else f"{g.shown}[{i}]"
            shown = inside if i else g.shown
            names.append(shown if g.is_turn or g.is_state else f"{shown}'")
    return [[q.name for q in unrolled.program.equations.rates].index(name) for name in names]


def at_random(unrolled, at, to: list[int], dice: random.Random, most: float = 1):
    """A state, and the matrices of members written out there, in the order of loops."""
    to = np.array(to)
    inputs = len(unrolled.program.equations.inputs)
    state = (
        dice.uniform(0, 3),
        *([dice.uniform(-most, most) for _ in range(n)] for n in (at.n, at.n, inputs)),
    )
    t, q, v, u = state
    there = [np.empty(at.n) for _ in range(2)]
    for x, y in zip(there, (q, v), strict=True):
        x[to] = y
    found = [
        np.array(x).reshape(at.n, at.n)[np.ix_(to, to)]
        for kernel in ("mass", "jacobian")
        for x in unrolled.call(kernel, t, *map(list, there), u)[1]
    ]
    mine = at.call("pulled" if closes(at) else "canonical", *state, (at.n, at.n))[1]
    written = unrolled.call("canonical", t, *map(list, there), u)[1]
    for one, other in zip(mine, written, strict=True):
        assert one == pytest.approx(np.array(other)[to], rel=1e-9, abs=1e-9)
    return state, found


def closes(at) -> bool:
    return bool(at.of.equations.bound or at.of.equations.solved)


def assert_closed(unrolled, at, size: int, dice: random.Random, text: str, scale: float) -> float:
    """That matrices with accelerations and multipliers for unknowns are those without."""
    state = at_random(unrolled, at, order(unrolled, at, size), dice, 0.5)
    return assert_newton(at, *state, text, scale)


def assert_newton(at, state, expected: list[np.ndarray], text: str, scale: float) -> float:
    M, p_q, pdot_q, pdot_v = expected
    found = matrices(at, "slopes_closed", state, 1)
    _, more = matrices(at, "slopes_jacobian", state, 3)
    (alone,) = dense(at, "slopes_mass", state, 1)
    assert np.allclose(alone, M.ravel(), rtol=1e-12, atol=1e-12), text
    for h, k in ((0.3, 0.2), (0.05, 0.7)):
        expected = M + h * p_q - k * pdot_v - h * k * pdot_q
        off = np.abs(closed(found, more, h, k) - expected).max()
        assert off <= scale * np.abs(expected).max(), f"{text}N = {at.n}: {off}"
    return np.abs(pdot_q).max() + np.abs(pdot_v).max()


FELT = {
    "mean": [line for line in MEAN.splitlines() if "i+1..N)/N^2" not in line],
    "hub": [line for line in HUB.splitlines() if "j = " not in line],
    "swelling": SWELLING.splitlines(),
    "rated": RATED.splitlines(),
    "still": RATES["still"][0].splitlines(),
}


@pytest.mark.parametrize("name", FELT)
def test_totals_are_unknowns(name: str, tmp_path) -> None:
    """So are rates of states that others use."""
    text = "\n".join(FELT[name]) + "\n"
    loops = Looped(text, tmp_path / "loops")
    for size in (1, 2, 4):
        unrolled, at = Written(text, size, tmp_path / f"n{size}"), loops.at(size)
        at.restless = True
        dice = random.Random(size)
        state, expected = at_random(unrolled, at, list(range(at.n)), dice)
        assert_newton(at, state, expected, text, 1e-11)


@pytest.mark.parametrize("seed", seeds(range(3), 22))
def test_constraints_are_closed_by_their_multipliers(seed: int, tmp_path) -> None:
    dice = random.Random(seed)
    text = bound(dice)
    loops = Looped(text, tmp_path / "loops")
    largest = 0.0
    for size in (1, 2, 3, 7):
        try:
            unrolled = Written(text, size, tmp_path / f"n{size}")
        except (ModelError, TooLarge):  # a row of one member may say nothing, M be too large
            continue
        largest = max(largest, assert_closed(unrolled, loops.at(size), size, dice, text, 1e-9))
    assert largest > 0


@pytest.mark.parametrize("seed", seeds(range(3), 12, [24]))
def test_rotations_have_bands(seed: int, tmp_path) -> None:
    """With accelerations for unknowns where momenta depend on attitudes."""
    dice = random.Random(seed)
    text = made(dice, 3).text
    loops = Looped(text, tmp_path / "loops")
    for size in (2, 3):  # the momenta of one member may depend on no attitude
        unrolled = Written(text, size, tmp_path / f"n{size}")
        at = loops.at(size)
        if closes(at):
            assert assert_closed(unrolled, at, size, dice, text, 1e-11) > 0
            continue
        state, expected = at_random(unrolled, at, order(unrolled, at, size), dice, 0.5)
        found = [*dense(at, "slopes_mass", state, 1), *dense(at, "slopes_jacobian", state, 3)]
        for one, other in zip(found, expected, strict=True):
            assert one == pytest.approx(other.ravel(), rel=2e-13, abs=2e-13), f"{text} N = {size}"
