"""Random chain models run with their families kept as loops and with all members written out.

python tests/fuzz/families.py FIRST LAST

Seeds go from FIRST to before LAST. Each model runs by several methods, with rows at events, as an
ensemble or a swarm, with a member held, by the accuracy asked for. Exit code 1 where the two
differ, where one crashes or hangs.
"""

import contextlib
import csv
import io
import json
import math
import os
import random
import re
import signal
import sys
import tempfile
import traceback
from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / x) for x in ("generator", "tests", "tests/generator")]
from carried_models import held, links, turned  # noqa: E402
from chain_models import drawn  # noqa: E402
from loop_runs import bodies, rope, states  # noqa: E402
from rotation_models import made  # noqa: E402

from pkgen.__main__ import main as command  # noqa: E402
from pkgen.compiler import compile_model  # noqa: E402
from pkgen.scenes import lengths  # noqa: E402
from pkgen.source import ModelError, Source  # noqa: E402

SECONDS = 600  # for a loaded machine
STEPS = ("--step", "0.02")
METHODS = {
    "rk4": STEPS,
    "gauss1": STEPS,
    "gauss2": STEPS,
    "gauss4": ("--step", "0.05"),
    "gauss8": ("--step", "0.1"),
    "lobatto2": STEPS,
    "lobatto3": STEPS,
    "lobatto4": STEPS,
    "radau5": STEPS,
    "radau9": ("--step", "0.05"),
    "radau": ("--rtol", "1e-10"),
    "gauss": ("--rtol", "1e-11"),
    "dopri5": ("--rtol", "1e-10"),
    "verlet": STEPS,
    "yoshida4": STEPS,
    "blanes_moan6": STEPS,
    "symplectic_euler": STEPS,
    "adaptive_verlet": STEPS,
    "boris": STEPS,
    "boris4": STEPS,
    "rattle": STEPS,
    "rattle4": STEPS,
    "lie_midpoint": STEPS,
    "lie_midpoint6": STEPS,
    "rkmk4": STEPS,
    "exponential": STEPS,
    "gsl_rk8pd": ("--rtol", "1e-11"),
    "gsl_msbdf": ("--rtol", "1e-8"),
    "gsl_msadams": ("--rtol", "1e-10"),
}
KINDS: dict[int, Callable[[random.Random], str]] = defaultdict(lambda: drawn) | {
    1: lambda dice: drawn(dice, jolts=True),
    2: bodies,
    3: links,
    5: held,
    6: lambda dice: states(dice, size=9),
    7: rope,
    9: turned,
    10: lambda dice: states(dice, coordinates=False, size=9),
    11: lambda dice: links(dice, states=True),
    13: lambda dice: drawn(dice, jolts=True),
    15: lambda dice: made(dice, dice.randint(1, 4)).text,
}
ROUGH = {"radau": 1e-6, "dopri5": 1e-6, "gsl_msbdf": 1e-3, "gsl_msadams": 1e-5, "gsl_rk8pd": 1e-6}
ADAPTIVE = {"dop853", "gauss", *ROUGH}
Answer = tuple[int, list[list[float]], dict, str]


def rows(path: Path) -> list[list[float]]:
    if not path.exists():
        return []
    return [[float(x) for x in row] for row in list(csv.reader(path.open()))[1:]]


def asked(folder: Path, *words: str) -> Answer:
    """Exit code, rows, report and what was said, of a command in this process."""
    out = folder / "rows.csv"
    out.unlink(missing_ok=True)
    told, said = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.redirect_stderr(said):
        code = command([*words, "--json", "-o", str(out)])
    text = told.getvalue()
    found = json.loads(text[text.index("{") :]) if "{" in text else {}
    if "internal error" in text + said.getvalue():
        raise AssertionError(text + said.getvalue())
    return code, rows(out), found.get("report", {}), found.get("error", "") + said.getvalue()


def both(folder: Path, *words: str) -> list[Answer]:
    usual, answers = (lengths.UNROLL, lengths.UNROLL_MEMBERS), []
    try:
        for unrolled in (0, 10**6):
            lengths.UNROLL = lengths.UNROLL_MEMBERS = unrolled
            answers.append(asked(folder, *words))
    finally:  # other tests run in this process
        lengths.UNROLL, lengths.UNROLL_MEMBERS = usual
    return answers


def apart(one: list[list[float]], other: list[list[float]]) -> float:
    """The largest difference, beside the largest number of its row and 1."""
    if len(one) != len(other) or any(len(a) != len(b) for a, b in zip(one, other, strict=True)):
        return math.inf
    worst = 0.0
    for a, b in zip(one, other, strict=True):
        a, b = sorted(a), sorted(b)  # rotations stand in another order
        if [*map(math.isfinite, a)] != [*map(math.isfinite, b)]:
            return math.inf
        scale = max([1.0, *(abs(x) for x in b if math.isfinite(x))])
        off = [abs(x - y) / scale for x, y in zip(a, b, strict=True) if math.isfinite(x)]
        worst = max([worst, *off])
    return worst


# What one side alone may refuse; the other's rows say nothing then.
LOOPS_LACK = (
    "are no band",
    "link by link",
    "the derivatives of the acceleration",
    "that is separable",
    "that is smooth",
    "forces affine in the rates",  # not proved beside values carried along a chain
)
WRITTEN_LACKS = ("too large", "limit")


def compared(folder: Path, words: tuple[str, ...], error: float, bends: bool = False) -> str:
    return differ(both(folder, *words), words, error, bends)


def differ(answers: list[Answer], words: tuple[str, ...], error: float, bends: bool = False) -> str:
    """Empty, or how the two differ. Steps end where it bends of what is written out alone."""
    (code, mine, told, said), (their_code, theirs, report, heard) = answers
    if code != their_code:
        if any(x in said for x in LOOPS_LACK) or any(x in heard for x in WRITTEN_LACKS):
            return ""
        return f"exit {code}, written out {their_code}: {said[:300]} | {heard[:300]}"
    if code not in (0, 4):
        return ""
    if any(x in said for x in LOOPS_LACK):
        return ""
    if code == 4 and told.get("status") != report.get("status"):
        return (
            f"ends with {told.get('status')}: {said[:300]} | {report.get('status')}: {heard[:300]}"
        )
    if code == 4 and not math.isclose(
        told.get("last_valid", 0), report.get("last_valid", 0), rel_tol=1e-2, abs_tol=0.05
    ):
        return f"ends at {told.get('last_valid')}, written out {report.get('last_valid')}: {said}"
    if code == 0 and (off := apart(mine, theirs)) > error:
        return f"rows differ by {off:.1e}"
    # A scene that asks for less is reduced: what it lacks has no switches.
    if "--method" in words and (off := jumps_apart(told, report, said, heard, code, error, bends)):
        return off
    if code == 4:
        return ""
    many = "--ensemble" in words  # of which only those with switches are watched one by one
    for one, other in zip(told.get("events", []), report.get("events", []), strict=not many):
        times, others = one.get("times", []), other.get("times", [])
        late = [abs(a - b) for a, b in zip(times, others, strict=False)]
        if len(times) != len(others) or max([0.0, *late]) > max(1e-6, 10 * error):
            return f"event {one['name']} at {times}, written out {others}"
    return ""


def jumps_apart(
    told: dict, report: dict, said: str, heard: str, code: int, error: float, bends: bool
) -> str:
    """Of switches: that steps end at the same ones at the same times, and slide on the same one."""
    near = max(1e-6, 10 * error)
    times = [  # but for a start on a switch: either side may be the first
        sorted(t for x in found.get("switches", []) for t in x.get("times", []) if t > near)
        for found in (told, report)
    ]
    if bends and times[1]:
        times[1] = [min(times[1], key=lambda t, own=own: abs(t - own)) for own in times[0]]
    if not (times[0] and times[1]):
        return "" if times[0] == times[1] else f"switches at {times[0]}, written out {times[1]}"
    slid = code == 4 and told.get("status") == "PK_SLIDING"
    if slid and "the motion" in said and name_of(said) != name_of(heard):
        return f"slides: {said[:300]} | {heard[:300]}"
    if slid and abs(told["last_valid"] - report["last_valid"]) > near:
        return f"slides at {told['last_valid']}, written out {report['last_valid']}"
    late = [abs(a - b) for a, b in zip(*times, strict=False)]
    if max(late) > near or (len(times[0]) != len(times[1]) and not slid):
        return f"switches at {times[0]}, written out {times[1]}"
    return ""


def name_of(said: str) -> str:
    """What the motion stays on, signs aside."""
    found = re.search(r"stays on (.*) = 0", said)
    return "".join(sorted(found[1].replace("-", "+"))) if found else said


def ways(dice: random.Random, text: str, folder: Path) -> list[tuple[tuple[str, ...], float]]:
    """Commands and the error that each may have."""
    model = str(folder / "chain.lag")
    given = ("--set", "push=0.3") if "input push" in text else ()
    until = ("--until", "0.4", "--every", "0.1", "--max-steps", "50000", *given)
    found = [(("run", model, *until, "--method", "dop853", "--rtol", "1e-11"), 1e-7)]
    for method in dice.sample(list(METHODS), 4):
        more = ("--at", "near") if "event near" in text and dice.random() < 0.3 else ()
        if method.startswith("gauss") and dice.random() < 0.2:
            more += ("--iteration", "fixed")
        words = ("run", model, *until, "--method", method, *METHODS[method], *more)
        found.append((words, ROUGH.get(method, 1e-7 if method == "gauss" else 1e-9)))
    if "param k" in text and dice.random() < 0.3:
        table = folder / "members.csv"
        table.write_text("k\n0.5\n1.2\n0.8\n")
        method = dice.choice(("rk4", "gauss2", "verlet", "dop853"))
        words = ("run", model, *until, "--ensemble", str(table), "--method", method)
        found.append(((*words, *METHODS.get(method, ())), 1e-8))
    if dice.random() < 0.15:
        found.append((("run", model, "--until", "0.2", "--every", "0.1", *given), 1e-6))
    if "\nscene" in text:
        found.append((("run", model, "--scene", "use", *given), 1e-6))
    return found


def scene(dice: random.Random, text: str) -> str:
    """One more statement: a swarm, a member that is held, a column, the accuracy asked for."""
    if dice.random() < 0.5:
        return ""
    families = re.findall(r"([qxyz])\[([-\d]+)\.\.(N[-+\d]*)\](?=[,\n])", text)
    if not families:
        return ""
    family, lo, hi = dice.choice(families)
    first, last = f"{family}[{lo}]", f"{family}[{hi}]"
    tied = "constraint" in text
    lines = ["scene use"]
    if "param k" in text:
        lines.append(f"  set k = {dice.uniform(0.3, 1.5):.3f}")
    kind = "column" if tied else dice.choice(("column", "swarm", "hold", "accuracy"))
    if kind == "swarm":
        lines = ["scene use\n  swarm n = 1..3"]
        lines.append(f"  start {first} = 0.1*n, {last}' = 0.2/n")
    elif not tied:
        lines.append(f"  start {last}' = 0.3")
    if kind == "hold" and f"periodic {family}" not in text:
        lines[:] = [line for line in lines if "start" not in line or hi != lo]
        lines.append(f"  hold {first} = {dice.choice(('0.2', 'sin(t)', 'k/3'))}")
    lines.append("  until 0.3")
    if kind == "accuracy":
        lines.append("  accuracy 1e-8")
    else:
        method = dice.choice(("dop853 rtol 1e-11", "gauss2 step 0.02", "rk4 step 0.02"))
        lines.append(f"  method {method}")
    lines.append(f"  record {last}, {last}' every 0.1\nend\n")
    return "\n".join(lines)


def friction(dice: random.Random, text: str) -> str:
    """One more statement: a force that jumps, of each member of a family that moves."""
    found = re.findall(r"(\w+)\[([-\d]+\.\.N[-+\d]*)\]", text.split("kinetic")[0])
    name, over = dice.choice([x for x in found if x[0] != "w" or "tie[" in text])
    felt = dice.choice(("sign({}' + 0.05)", "step({}' - 0.1)", "{}*step({} - 0.3)"))
    return f"force {name}[i = {over}] = -0.2*{felt.replace('{}', name + '[i]')}\n"


def text_of(seed: int, dice: random.Random | None = None) -> str:
    """Of one kind in sixteen: chains, links, ropes, bodies, spins, states of members."""
    dice = dice or random.Random(seed)
    text = KINDS[seed % 16](dice)
    if seed % 16 in (3, 7) and dice.random() < 0.4:
        text += friction(dice, text)
    return text + scene(dice, text)


def judged(seed: int, folder: Path) -> tuple[str, str]:
    dice = random.Random(seed)
    text = text_of(seed, dice)
    model = folder / "chain.lag"
    model.write_text(text)
    try:
        made = compile_model(Source(str(model), text))
    except ModelError as error:
        return "refused", error.diagnostics[0].message
    if made.equations.dense:
        return "written out", str(made.equations.unrolled)
    bends = any(word in text for word in ("max(", "min(", "abs(", "clamp("))  # no steps end there
    for words, error in ways(dice, text, folder):
        error = max(error, 3e-3) if bends else error
        wrong = compared(folder, words, error, bends)
        if wrong:
            return "DIFFER", f"{' '.join(words[2:])}: {wrong}"
    return "agree", ""


def alone(seed: int) -> tuple[str, str]:
    """In a process of its own, which may crash or hang."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        child = os.fork()
        if child == 0:
            signal.alarm(SECONDS)
            try:
                answer = judged(seed, folder)
            except BaseException:
                answer = "BROKEN", traceback.format_exc()
            (folder / "answer").write_text(json.dumps(answer))
            os._exit(0)
        _, status = os.waitpid(child, 0)
        if (folder / "answer").exists():
            verdict, seen = json.loads((folder / "answer").read_text())
            return verdict, seen
        sign = os.WTERMSIG(status)
        return ("HANGS" if sign == signal.SIGALRM else "CRASHES"), f"signal {sign}"


BAD = ("DIFFER", "BROKEN", "HANGS", "CRASHES")


def hunt(seeds: range) -> Counter[str]:
    count: Counter[str] = Counter()
    for seed in seeds:
        verdict, seen = alone(seed)
        count[verdict] += 1
        print(f"{seed:6} {verdict:11} {seen}", flush=True)
    return count


if __name__ == "__main__":
    total = hunt(range(int(sys.argv[1]), int(sys.argv[2])))
    print(", ".join(f"{n} {verdict}" for verdict, n in total.items()))
    sys.exit(any(total[verdict] for verdict in BAD))
