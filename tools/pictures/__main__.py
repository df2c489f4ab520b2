"""Every picture of docs/pictures and what makes it: `make pictures`, some by ONLY="kepler.png".

Those of pkgen's own commands are what the commands leave; the others are drawn here from rows of
`pkgen run`, in the look of pkgen's own, or seen in a browser.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bodies
import classical
import live
from rows import OUTPUT, ROOT, drawn

CARD = ("bead_on_hoop", "coupled_oscillators", "double_pendulum", "elastic_pendulum", "heavy_top")
# Models in tests/regimes/models: a struck wall, a touched wall, smooth friction.
REGIMES = {
    "walled_pendulum": "8 --methods verlet,rk4,dopri5,dop853,gauss,radau",
    "touched_wall": "2 --methods verlet,rk4,dopri5,dop853,gauss,radau",
    "creep": "2 --methods rk4,dopri5,dop853,gauss,radau,radau5",
}
RUN = "run models/double_pendulum.lag --step 0.01 --until 100"
# The commands, and the file that the last one leaves.
COMMANDS: dict[str, tuple[list[str], str]] = {
    **{f"chart_{m}.svg": ([f"chart models/{m}.lag"], f"{m}_chart.svg") for m in CARD},
    **{
        f"chart_{m}.svg": (
            [f"chart regimes/{m}.lag --cost evaluations --until {how}"],
            f"{m}_chart.svg",
        )
        for m, how in REGIMES.items()
    },
    **{f"stability_{m}.svg": ([f"stability models/{m}.lag"], f"{m}_stability.svg") for m in CARD},
    "plot_over_time.svg": (["plot models/double_pendulum.lag -o p.svg"], "p.svg"),
    "plot_path.svg": (
        ["plot models/double_pendulum.lag --path x2,y2 --path x1,y1 -o p.svg"],
        "p.svg",
    ),
    "plot_section.svg": (
        ["plot models/particles/henon_heiles.lag --scene sections -o p.svg"],
        "p.svg",
    ),
    "plot_drift.svg": (["plot models/heavy_top.lag --drift --until 300 -o p.svg"], "p.svg"),
    "plot_chain.svg": (
        ["plot models/chains/fput.lag --columns q --until 640 --every 1 -o p.svg"],
        "p.svg",
    ),
    "plot_both.svg": (
        [
            f"{RUN} --method rk4 -o rk4.csv",
            f"{RUN} --method gauss2 -o gauss2.csv",
            "plot rk4.csv gauss2.csv --drift -o p.svg",
        ],
        "p.svg",
    ),
    "sweep_map.png": (
        [
            "sweep models/double_pendulum.lag --plan models/flips_grid.toml -o flips",
            "plot flips -o p.png",
        ],
        "p.png",
    ),
    "duffing.png": (
        ["continue duffing.lag --free omega=0.5:3 --orbit start --period T --output duffing.png"],
        "duffing.png",
    ),
    "swing_up.svg": (
        [
            "optimise cart_pole.lag --integral F^2 --linear --input F=-20:20 --path x=-2:2"
            """ --end x=1 --end "x'=0" --end theta=pi --end "theta'=0" --until 2 -o swing_up.svg"""
        ],
        "swing_up.svg",
    ),
    "film_double_pendulum.gif": (
        ["film models/double_pendulum.lag -o p.gif --seconds 6 --pixels 400x300"],
        "p.gif",
    ),
    "film_space_arm.gif": (
        ["film models/bodies/space_arm.lag -o p.gif --seconds 8 --pixels 400x300"],
        "p.gif",
    ),
}
ON_PAGES = {"duffing.lag": "bifurcation", "cart_pole.lag": "optimise"}
DRAWN = {f"{f.__name__}.png": f for f in (*classical.PICTURES, *bodies.PICTURES)}
SEEN = {"show.png": live.still, "show.webp": live.moving}


def commanded(name: str) -> bytes:
    lines, left = COMMANDS[name]
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "models").symlink_to(ROOT / "models")
        Path(folder, "regimes").symlink_to(ROOT / "tests/regimes/models")
        for model, addon in ON_PAGES.items():
            page = (ROOT / "addons" / addon / "README.md").read_text(encoding="utf-8")
            text = page.partition("```lag\n")[2].partition("```")[0]
            Path(folder, model).write_text(text, encoding="utf-8")
        for line in lines:
            words = [sys.executable, "-m", "pkgen", *shlex.split(line)]
            done = subprocess.run(words, cwd=folder, capture_output=True, text=True)
            if done.returncode:
                raise SystemExit(f"pictures: pkgen {line}: {done.stderr}")
        return Path(folder, left).read_bytes()


def made(name: str) -> bytes:
    if name in COMMANDS:
        return commanded(name)
    return drawn(DRAWN[name]) if name in DRAWN else SEEN[name]()


def main(names: list[str]) -> int:
    every = [*COMMANDS, *DRAWN, *SEEN]
    if unknown := set(names).difference(every):
        print(f"pictures: there is no {', '.join(unknown)}; there are {', '.join(every)}")
        return 2
    for name in names or every:
        began = time.monotonic()
        content = made(name)
        (OUTPUT / name).write_bytes(content)
        print(f"{name}: {len(content) / 1000:.0f} kB, {time.monotonic() - began:.0f} s", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
