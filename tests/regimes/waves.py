"""What a step makes of orbits and waves, exactly."""

from math import asin

from .shown import shown

PREDICTIONS = [
    shown(
        "W1", "Kepler's circle, verlet, h = 1", "a hexagon: turns by 2 asin(h/2) a step",
        2 * asin(0.5), 1e-9,
        "pkgen run hexagon.lag --method verlet --step 1 --until 600 --every 1",
        "unwrap(arctan2(y, x))[-1]/600", "--method rk4",
    ),
    shown(
        "W2", "ring of 40 masses, verlet, h = 1", "the longest step is the best: no wave "
        "disperses, and one site is back to the bit after 40", 1.0, 0,
        "pkgen run ring.lag --method verlet --step 1 --until 40 --every 1", "q_1_[-1]",
        "--method rk4",
    ),
    shown(
        "W3", "charge in crossed fields, boris, y = 20", "turns wrongly, yet drifts at -E/b", -0.1,
        1e-4, "pkgen run crossed.lag --method boris --step 20 --until 20000 --every 20",
        "polyfit(t, y, 1)[0]", "--method rk4",
    ),
]  # fmt: skip
