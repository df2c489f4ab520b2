"""Euler's disk (X1), whose motion ends, and a throw through air (X2), whose force has a kink."""

import mpmath as mp

from .shown import listed

DRAG = (
    mp.log(1 + 0.02 * mp.mpf(2500) / mp.mpf("9.81")) / mp.mpf("0.04"),
    mp.atan(50 * mp.sqrt(mp.mpf("0.02") / mp.mpf("9.81")))
    / mp.sqrt(mp.mpf("0.02") * mp.mpf("9.81")),
    50 / mp.sqrt(1 + 0.02 * mp.mpf(2500) / mp.mpf("9.81")),
)

STONE = "pkgen run ../../../models/particles/thrown_stone.lag --method dop853 --until 10"

PREDICTIONS = [
    *(
        listed(
            id, f"Euler's disk{of}, dop853",
            "stops with PK_SINGULAR_TIME, its last valid time at theta0^2/(2 k)", 2.0, 1e-9,
            f"pkgen run {model}.lag --method dop853 --until 3",
            'report["last_valid"] if report["status"] == "PK_SINGULAR_TIME" else 0',
            "--method rk4 --step 0.03",
        )
        for id, of, model in (
            ("X1", ", theta0 = .2, k = .01", "euler_disk"),
            ("X1a", " of first order, theta' = -k/theta", "euler_disk_first"),
        )
    ),
    *(
        listed(
            f"X2{'abc'[i]}", "ball in air, k = .02, 50 m/s straight up, dop853", text,
            float(DRAG[i]), 1e-9, STONE + more, read, "--method rk4 --step 0.1",
        )
        for i, (text, more, read) in enumerate(
            (
                ("apex", " --at apex", "max(y)"),
                ("time of the apex", "", 'times(report, "apex")[0]'),
                ("speed of impact", "", "-y'[-1]"),
            )
        )
    ),
]  # fmt: skip
