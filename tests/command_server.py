"""The command line in processes forked from one that has imported pkgen already.

Imports are more than half of what a small command costs, and those of pictures half a second. That
a command imports no more than it uses is seen in test_start.py. Each line of standard input is a
request, {"arguments", "cwd", "env", "out", "err"}; each line of standard output the exit code of
its process.
"""

import gc
import importlib
import json
import os
import pkgutil
import resource
import signal
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress

import matplotlib.backends.backend_svg
import matplotlib.pyplot  # noqa: F401
import sympy.combinatorics  # noqa: F401

import pkgen
from pkgen.__main__ import main
from pkgen.compiler import compile_model
from pkgen.source import Source
from pkgen.system import toolchain
from pkgen.system.exits import BuildError

LONGEST = 300  # s of the processor, which a loaded machine does not use up; then it is killed


# What a first model of a process costs more: units, parser tables, templates, ways to derive.
WARM = """model warm
param m = 1 [kg]
coord x [m], y [m]
param k = 1 [N/m]
param a = 9 [deg]
kinetic m*(x'^2 + y'^2)/2
potential k*x^2/2 + m*(9.81 [m/s^2])*x*cos(a + y/(1 [m]))
constraint rod: x^2 + y^2 = 1 [m^2]
start x = 1
"""


def remembered(ask: Callable[[list[str]], str | None]) -> Callable[[list[str]], str | None]:
    """What a compiler says of itself, as far as it has been asked before fork()."""
    known: dict[tuple, str | None] = {}

    def answer(command: list[str]) -> str | None:
        key = (os.environ.get("PATH"), *command)
        if key not in known:
            known[key] = ask(command)
        return known[key]

    return answer


def warm() -> None:
    """All that its children would else import or read, each of them again."""
    for module in pkgutil.walk_packages(pkgen.__path__, "pkgen."):
        importlib.import_module(module.name)
    compile_model(Source("warm.lag", WARM))
    toolchain._output = remembered(toolchain._output)
    with suppress(BuildError):
        toolchain.find_toolchain()
    gc.freeze()  # or a collection in a child would write to all of its pages


def serve() -> None:
    warm()
    for line in sys.stdin:
        request = json.loads(line)
        process = os.fork()
        if process == 0:
            os._exit(run(request))
        _, status = os.waitpid(process, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


def run(request: dict) -> int:
    resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))
    signal.alarm(20 * LONGEST)
    os.chdir(request["cwd"])
    os.environ.clear()
    os.environ.update(request["env"])
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for fd, name in ((1, "out"), (2, "err")):
        os.dup2(os.open(request[name], os.O_WRONLY | os.O_CREAT | os.O_TRUNC), fd)
    sys.argv[0] = "pkgen"
    try:
        code = main(request["arguments"])
    except SystemExit as exit_:
        code = exit_.code if isinstance(exit_.code, int) else 1
    except BaseException:  # as an interpreter of its own would end
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    return code


if __name__ == "__main__":
    serve()
