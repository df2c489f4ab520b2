"""Checkpoints that somebody has forged: bytes behind the head are changed, and the sum with them.

    python tests/fuzz/checkpoints.py SECONDS [SEED]

goes on from such files with runs of each kind, under the address and undefined sanitizers of gcc:
each is refused, fails or runs. Nothing is read outside memory, nothing hangs. What fails is left in
build/fuzz.
"""

import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LEFT = ROOT / "build/fuzz"
FLAGS = "-g -O1 -fsanitize=address,undefined -fno-sanitize-recover=all"
HANGS = 10  # seconds that no run of a few steps takes
STEPS = 20  # that are made of a state
RUNS = (
    ("free", "gauss adaptive_verlet verlet"),
    ("damped", "dop853 radau gauss3 gsl_rk8pd"),
    ("bound", "lobatto3 dop853"),
    ("rods", "gauss4 rattle4"),
    ("turning", "lie_midpoint4 rkmk8"),
    ("events", "dop853 gauss verlet"),
    ("switched", "gauss2 dop853"),
    ("struck", "dopri5"),
    ("fast", "respa"),
    ("short", "dop853"),
    ("affine", "exponential"),
    ("linear", "boris4"),
    ("chain", "verlet"),
    ("walled", "gauss2 dop853"),
)
NUMBERS = [
    *(struct.pack("=d", x) for x in (float("nan"), float("inf"), -1e300, 1e300, 5e-324, -0.5)),
    *(struct.pack("=q", x) for x in (0, 1, -1, 7, 1 << 20, 1 << 40, -(1 << 63))),
    *(struct.pack("=i", x) for x in (0, 1, -1, 7, 1 << 20, 0x7FFFFFFF, -(1 << 31))),
]  # fmt: skip
HEAD, NOTE, STATE = (
    48,
    44,
    64,
)  # bytes of the head, where it has the note's length; the model's hash


def forged(good: bytes, dice: random.Random) -> bytes:
    """Numbers that are none, or too large; behind the model's hash, most of them in the state."""
    bad = bytearray(good)
    begin = HEAD + struct.unpack_from("=I", good, NOTE)[0] + STATE
    for _ in range(dice.choice((1, 1, 1, 2, 5))):
        at = dice.randrange(begin, len(bad))
        if dice.random() < 0.3:
            bad[at] ^= 1 << dice.randrange(8)
            continue
        x = dice.choice(NUMBERS)
        at = min(at - (at - begin) % 4, len(bad) - len(x))
        bad[at : at + len(x)] = x
    bad[20:24] = struct.pack("=I", zlib.crc32(bad[24:]))
    return bytes(bad)


def hunted(seconds: float, seed: int, file: Path) -> None:
    """In a process with the sanitizers, which ends where they find something."""
    sys.path[:0] = [str(ROOT), str(ROOT / "tests")]
    import signal

    import checkpoint_runs as runs

    from pkgen.run.library import load

    dice = random.Random(seed)
    tried: dict[int, int] = {}
    with tempfile.TemporaryDirectory() as folder:
        models = {name: runs.of(name, Path(folder)) for name in dict(RUNS)}
        cases = [(name, method) for name, methods in RUNS for method in methods.split()]
        dice.shuffle(cases)
        until = time.monotonic() + seconds  # from when they are compiled on
        while time.monotonic() < until:
            name, method = cases[sum(tried.values()) // 40 % len(cases)]
            what = runs.by(models[name], method, diagnose=dice.choice(((), ("lrl",))))
            run = load(what.library).run
            how = {"checkpoint": bytes(file), "checkpoint_after": dice.randint(1, 200)}
            file.unlink(missing_ok=True)
            if run(what.settings, None, None, **how).code != 75:
                tried[-1] = tried.get(-1, 0) + 40
                continue
            good = file.read_bytes()
            print(name, method, file=sys.stderr, flush=True)
            for _ in range(40):
                file.write_bytes(forged(good, dice))
                signal.alarm(HANGS)
                found = run(
                    what.settings, None, None, resume=1, **{**how, "checkpoint_after": STEPS}
                )
                signal.alarm(0)
                assert found.code in (0, 2, 4, 75), (name, method, found.code)
                tried[found.code] = tried.get(found.code, 0) + 1
    print(tried)


def library(name: str) -> str:
    found = subprocess.run(["gcc", f"-print-file-name={name}"], capture_output=True, text=True)
    return found.stdout.strip()


def main() -> int:
    seconds, seed = float(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1
    LEFT.mkdir(parents=True, exist_ok=True)
    flags = {
        "CC": "gcc",
        "CFLAGS": FLAGS,
        "LD_PRELOAD": f"{library('libasan.so')} {library('libubsan.so')}",
    }
    more = {"ASAN_OPTIONS": "detect_leaks=0", "PYTHONMALLOC": "malloc", "GUARD": "1"}
    env = {**os.environ, **flags, **more}
    until, found = time.monotonic() + seconds, 0
    while (left := until - time.monotonic()) > 0:
        file = LEFT / f"checkpoint-{seed}"
        command = [sys.executable, __file__, "hunt", str(left), str(seed), str(file)]
        done = subprocess.run(command, env=env, capture_output=True, text=True)
        print(f"seed {seed}: {done.stdout.strip()}", flush=True)
        if done.returncode:
            found += 1
            print(f"{file}: ended by {done.returncode}\n{done.stderr[-3000:]}", flush=True)
            shutil.copy(file, LEFT / f"forged-{seed}") if file.exists() else None
        file.unlink(missing_ok=True)
        seed += 1
    return found > 0


if __name__ == "__main__":
    if sys.argv[1] == "hunt":
        hunted(float(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]))
    else:
        sys.exit(main())
