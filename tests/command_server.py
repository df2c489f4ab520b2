"""The command line in processes forked from one that has imported pkgen already.

Imports are more than half of what a small command costs, and those of pictures half a second. That
a command imports no more than it uses is seen in test_start.py. Each line of standard input is a
request, {"arguments", "cwd", "env", "out", "err"}; each line of standard output the exit code of
its process.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import traceback

import matplotlib.backends.backend_svg
import matplotlib.pyplot  # noqa: F401
from pkgen.__main__ import main
from pkgen.compiler import compile_model
from pkgen.source import Source

LONGEST = 120  # s of the processor, which a loaded machine does not use up; then it is killed


def serve() -> None:
    compile_model(Source("warm.lag", "model warm\ncoord x\nkinetic x'^2/2\npotential cos(x)\n"))
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
