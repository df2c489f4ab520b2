"""run.py MODEL.so < SETTINGS: one run by the runtime's layer, settings a line each, for driver.sh.

Rows go to standard output, messages to standard error, the report where `report PATH` says.
"""

import array
import sys
from dataclasses import replace
from pathlib import Path

from pkgen.run.ensemble import Column, Ensemble
from pkgen.run.library import Library
from pkgen.run.settings import PartSettings, Settings, Shown
from pkgen.system import children

START = Settings("", 0.0, None, None, 1e-8, None, "newton", 0, None, (), (), (), (), ())
REALS = {"until": "until", "every": "every", "step": "step", "rtol": "rtol", "atol": "atol"}


def number(word: str) -> float:
    return float.fromhex(word) if "0x" in word else float(word)


def main(path: str, text: str) -> int:
    s, more, parts, columns, members = START, {}, {}, [], 0
    report, data, progress = None, None, False
    for words in (line.split() for line in text.splitlines() if line.strip()):
        match words:
            case ["report", where]:
                report = Path(where)
            case ["method" | "rows" | "iteration" as name, word]:
                s = replace(s, **{name: word})
            case [name, word] if name in REALS:
                s = replace(s, **{REALS[name]: number(word)})
            case ["max_steps", word]:
                s = replace(s, max_steps=int(word))
            case ["progress", word]:
                progress = word == "1"
            case ["h_min", word]:
                more["h_min"] = number(word)
            case ["param", i, x]:
                s = replace(s, parameters=(*s.parameters, (int(i), number(x))))
            case ["start", kind, i, x] if kind in ("q", "v", "z"):
                have = getattr(s, f"start_{kind}")
                s = replace(s, **{f"start_{kind}": (*have, (int(i), number(x)))})
            case ["show", kind, *i]:
                s = replace(s, show=(*s.show, Shown(kind, int(*i or [0]), "")))
            case ["diagnose", name]:
                s = replace(s, diagnose=(*s.diagnose, name))
            case ["part", k, name, word]:
                parts.setdefault(int(k), {})[name] = word
            case ["ensemble", where]:
                data = Path(where).read_bytes()
            case ["members", word]:
                members = int(word)
            case ["column", kind, i]:
                columns.append(Column("", kind, int(i), ""))
            case _:
                print("run: not a setting:", *words, file=sys.stderr)
                return 2
    try:
        return run(
            Library(Path(path).absolute()), s, more, parts, columns, members, data, report, progress
        )
    except ValueError as error:
        print(f"run: {error}", file=sys.stderr)
        return 2


def run(library, s, more, parts, columns, members, data, report, progress) -> int:
    if parts:
        given = [parts.get(k, {}) for k in range(max(2, *(k + 1 for k in parts)))]
        s = replace(s, parts=tuple(part(s, one) for one in given))
    ensemble = None
    if data is not None:
        ensemble = Ensemble("", tuple(columns), range(1, members + 1), array.array("d", data))

    def poll(share: float) -> bool:
        if progress:
            print(f"progress {share:.4g}", file=sys.stderr, flush=True)
        return stopped()

    with children.stopping() as stopped:
        done = library.run(s, poll, ensemble, csv=1, **more)
    for line in done.messages.splitlines():
        print("run:", line, file=sys.stderr)
    if report:
        report.write_text(library.c.pk_run_report(done._run).decode())
    return done.code


def part(s: Settings, words: dict[str, str]) -> PartSettings:
    step = words.get("step")
    return PartSettings(
        words.get("method", s.method),
        None if step is None else number(step),
        number(words["rtol"]) if "rtol" in words else s.rtol,
    )


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1], sys.stdin.read()))
    except ValueError as error:
        print(f"run: {error}", file=sys.stderr)
        sys.exit(2)
