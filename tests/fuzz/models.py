"""A mutator of models that knows their words: right and wrong ones, bent a little.

    python tests/fuzz/models.py SECONDS [SEED]

compiles mutated models, each in a process of its own: no traceback, no internal error, no hang, no
process or connection made, an exit code that is known; and C of what was accepted compiles without
a warning. What fails is left in build/fuzz. tests/generator/test_fuzz.py asks the front end alone.
"""

import os
import random
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pkgen.__main__ import main as command
from pkgen.compiler import compile_model
from pkgen.source import Source

ROOT = Path(__file__).resolve().parents[2]
MOST_BYTES = 4000
WARM = "model warm\ncoord x\nkinetic x'^2/2\npotential cos(x)\n"
CPU_SECONDS = 30
STRICT = "-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror"
EXTRA = """model many
size N = 3
param a[i = 1..N] = 2 [m] in (0 [cm], inf)
const c = 3 [N]
coord q[1..N] [m], x [m]
fixed q[0] = 0, q[N+1] = a[1]*sin(2*t/(1 [s]))
input u [m]
let X[0] = 0
let X[i = 1..N] = X[i-1] + q[i]
let P = [x, u, X[2]]
param m = 1 [kg]
kinetic m/2*dot(P', P') + sum(m/2*q[i]'^2, i = 1..N)
potential sum(c/a[i]*(q[i+1] - q[i])^2/2, i = 1..N) - c*norm(P)
force q[i = 1..N] = -c*q[i]/a[i]
dissipation c*x'^2/2/(1 [m/s])
observe e[i = 1..N] = p_q[i]
conserve h = energy
start q[i = 1..N] = sin(pi*i/(N+1)), x' = 0.1
event cross: x rising stop
scene one
  set m = 2 [kg]
  hold x = (1 [m])*sin(t/(1 [s]))
  record x, q[1] every 0.1 [s] at cross
  expect drift(energy) < 1e-9
  until 3
end
"""
BITS = [
    *"()[]+-*/^',=.:'\"#\\{}\n\t é²θ\0∞", "..", "**", "''", " [m]", "[1]", "1e400", "1e-400",
    "9^9^9^9", "inf", "t", "pi", "energy", "T", "q[i]", "sum(", "sum(x, i = 1..3)", "step", "in (",
    "\nend\n", "\nlet ", "\nscene s\n", "\nmodel b\n", "[x, 0, 0]", ".x", "0", "99999", "-1",
    "norm(", "[kg*m/s^2]", "\nperiodic q\n", "\nfree q\n", " at ", " every ",
]  # fmt: skip
WORD = re.compile(r"\w+|\s+|[^\w\s]")


def mutated(random_: random.Random, text: str) -> str:
    parts = WORD.findall(text)
    for _ in range(random_.choice((1, 1, 2, 3, 8))):
        at = random_.randrange(len(parts)) if parts else 0
        kind = random_.randrange(6)
        if kind == 0:
            del parts[at : at + random_.choice((1, 1, 2, 10))]
        elif kind == 1:
            parts.insert(at, random_.choice(BITS))
        elif kind == 2 and parts:
            parts.insert(at, random_.choice(parts))
        elif kind == 3 and parts:
            parts[at] = random_.choice(parts)
        elif kind == 4 and parts:
            other = random_.randrange(len(parts))
            parts[at], parts[other] = parts[other], parts[at]
        elif parts:
            word = parts[at]
            cut = random_.randrange(len(word) + 1)
            parts[at] = word[:cut] + random_.choice(BITS) + word[cut + random_.randrange(2) :]
    return "".join(parts)


def corpus() -> list[str]:
    """The models, the examples of docs, what is known to be wrong."""
    models = sorted((ROOT / "models").rglob("*.lag"))
    wrong = sorted((ROOT / "tests/generator/wrong").glob("*.lag"))
    texts = [path.read_text(encoding="utf-8") for path in 4 * models + wrong]
    for page in sorted([*ROOT.glob("docs/**/*.md"), *ROOT.glob("addons/*/*.md")]):
        text = page.read_text(encoding="utf-8")
        texts += re.findall(r"^```\w*\n(model .*?)^```", text, re.M | re.S)
    return [text for text in texts if len(text) < MOST_BYTES] + [EXTRA] * 20


def _watch(event: str, arguments: tuple[object, ...]) -> None:
    if event in ("os.system", "os.exec", "subprocess.Popen", "socket.connect"):
        os.write(2, f"pkgen: internal error: {event} {arguments}\n".encode())
        os._exit(99)


def compiled(path: Path, folder: Path) -> tuple[int, str]:
    """Exit code (negative: a signal) and messages of `pkgen MODEL -o FOLDER`, in a process."""
    out = folder / "out"
    process = os.fork()
    if process == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS))
        stream = os.open(out, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(stream, 1), os.dup2(stream, 2)
        sys.addaudithook(_watch)
        code = 98
        try:
            code = command([str(path), "-o", str(folder / "c"), "--max-seconds", "8"])
        except SystemExit as error:
            code = error.code if isinstance(error.code, int) else 97
        finally:
            sys.stdout.flush(), sys.stderr.flush()
            os._exit(code)
    _, status = os.waitpid(process, 0)
    return os.waitstatus_to_exitcode(status), out.read_text(encoding="utf-8", errors="replace")


def judged(text: str, c_too: bool) -> tuple[str, str]:
    """ "right", "wrong", or what is wrong with pkgen; and its words."""
    with tempfile.TemporaryDirectory() as directory:
        folder = Path(directory)
        path = folder / "fuzz.lag"
        path.write_text(text, encoding="utf-8")
        (folder / "c").mkdir()
        code, words = compiled(path, folder)
        if code not in (0, 1) or "internal error" in words or "Traceback" in words:
            return f"exit {code}", words
        if code:
            return ("wrong", words) if words.strip() else ("silent", words)
        for source in (folder / "c").glob("*.c") if c_too else ():
            command = ["gcc", *STRICT.split(), "-fsyntax-only", str(source)]
            done = subprocess.run(command, capture_output=True, text=True, cwd=source.parent)
            if done.returncode:
                return "C that does not compile", done.stderr
        return "right", words


def main() -> int:
    seconds = float(sys.argv[1])
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else int(time.time())
    random_ = random.Random(seed)
    texts, end = corpus(), time.monotonic() + seconds
    counts: dict[str, int] = {}
    compile_model(Source("warm.lag", WARM))  # what is made once, before processes are
    while time.monotonic() < end:
        text = mutated(random_, random_.choice(texts))
        outcome, words = judged(text, c_too=counts.get("right", 0) % 4 == 0)
        counts[outcome] = counts.get(outcome, 0) + 1
        if outcome not in ("right", "wrong"):
            folder = ROOT / "build" / "fuzz"
            folder.mkdir(parents=True, exist_ok=True)
            kept = folder / f"{seed}-{sum(counts.values())}.lag"
            kept.write_text(text, encoding="utf-8")
            print(f"{kept}: {outcome}\n{words}", flush=True)
    print(f"models, seed {seed}:", ", ".join(f"{n} {what}" for what, n in sorted(counts.items())))
    return 0 if set(counts) <= {"right", "wrong"} else 1


if __name__ == "__main__":
    sys.exit(main())
