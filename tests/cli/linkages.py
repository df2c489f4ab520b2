"""Random linkages of rods in a plane, in maximal coordinates and in angles.

Each rod has its centre and its angle as coordinates, and is pinned by constraints. A new rod hangs
on a tip; a loop is a parallelogram on a rod that is there, so that angles alone describe it too.
"""

from __future__ import annotations

import random
from dataclasses import dataclass

G = 9.81


@dataclass(frozen=True)
class Rod:
    angle: str  # its own, of a minimal model
    length: float
    mass: float


@dataclass(frozen=True)
class Linkage:
    maximal: str
    minimal: str
    rods: tuple[Rod, ...]
    time: float  # until when it is worth to look
    sharpest: tuple[tuple[str, str], ...]  # angles between which a parallelogram must not lie flat


def _place(path: tuple[int, ...], rods: list[Rod], function: str, sign: str) -> str:
    return "".join(f" {sign} {rods[k].length!r}*{function}({rods[k].angle})" for k in path)


def linkage(seed: int, spread: float = 8) -> Linkage:
    """2 to 12 rods with up to 3 loops, of masses and lengths that differ by up to 10**spread."""
    pick = random.Random(seed)
    masses, lengths = (pick.uniform(0, spread) for _ in range(2))
    rods: list[Rod] = []
    paths: list[tuple[int, ...]] = []  # rods from the pivot to each rod's base
    pins: list[tuple[int, int]] = []  # the tip of one rod on that of another
    loops: list[tuple[str, str]] = []
    angles = 0

    def add(path: tuple[int, ...], angle: str, length: float) -> int:
        rods.append(Rod(angle, length, 10 ** pick.uniform(-masses / 2, masses / 2)))
        paths.append(path)
        return len(rods) - 1

    count, wanted = pick.randint(2, 12), pick.randint(0, 3)
    while len(rods) < count:
        angle = f"a{angles}"
        angles += 1
        length = 10 ** pick.uniform(-lengths, 0)
        if rods and wanted and len(rods) + 3 <= 12:
            wanted -= 1
            side = pick.randrange(len(rods))
            foot = add(paths[side], angle, length)
            tip = add((*paths[side], side), angle, length)
            top = add((*paths[side], foot), rods[side].angle, rods[side].length)
            pins.append((top, tip))
            loops.append((angle, rods[side].angle))
        else:
            on = pick.randrange(len(rods) + 1)
            add((*paths[on - 1], on - 1) if on else (), angle, length)
    starts = {f"a{k}": round(pick.uniform(-2, 2), 3) for k in range(angles)}
    shortest = min(rod.length for rod in rods)
    minimal = [f"model minimal\nparam g = {G}\ncoord {', '.join(starts)}"]
    maximal = [f"model maximal\nparam g = {G}"]
    maximal.append("coord " + ", ".join(f"x{k}, y{k}, r{k}" for k in range(len(rods))))
    start = []
    for k, rod in enumerate(rods):
        of, length, m = rod.angle, repr(rod.length), repr(rod.mass)
        x = f"{_place(paths[k], rods, 'sin', '+')} + {length}/2*sin({of})"
        y = f"{_place(paths[k], rods, 'cos', '-')} - {length}/2*cos({of})"
        kinetic = f"kinetic {m}/2*(x{k}'^2 + y{k}'^2) + {m}*{length}^2/24*"
        minimal += [f"let x{k} = 0{x}", f"let y{k} = 0{y}", f"{kinetic}{of}'^2"]
        minimal.append(f"potential {m}*g*y{k}")
        maximal += [f"{kinetic}r{k}'^2", f"potential {m}*g*y{k}"]
        base = paths[k][-1] if paths[k] else None
        for c, function, sign in (("x", "sin", "-"), ("y", "cos", "+")):
            tip = f"({c}{k} {sign} {length}/2*{function}(r{k}))"
            other = "0"
            if base is not None:
                back = "+" if sign == "-" else "-"
                other = f"{c}{base} {back} {rods[base].length!r}/2*{function}(r{base})"
            maximal.append(f"constraint base{c}{k}: {tip} = {other}")
        here = dict(starts)
        values = [f"{c}{k} = 0{text}" for c, text in (("x", x), ("y", y))]
        for angle, value in here.items():
            values = [v.replace(f"({angle})", f"({value!r})") for v in values]
        start += [*values, f"r{k} = {starts[of]!r}"]
    for top, tip in pins:
        for c, function, sign in (("x", "sin", "+"), ("y", "cos", "-")):
            ends = [f"{c}{k} {sign} {rods[k].length!r}/2*{function}(r{k})" for k in (top, tip)]
            maximal.append(f"constraint pin{c}{top}: {ends[0]} = {ends[1]}")
    minimal.append("start " + ", ".join(f"{a} = {value!r}" for a, value in starts.items()))
    maximal.append("start " + ", ".join(start))
    time = 2 * (shortest / G) ** 0.5
    return Linkage(
        "\n".join(maximal) + "\n", "\n".join(minimal) + "\n", tuple(rods), time, tuple(loops)
    )
