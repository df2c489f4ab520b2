"""A worker of the local engine: `python -m pkgen_sweep.worker`, started by pkgen.

It reads the pickled job and then a task per line from standard input, until that ends. It writes a
line of JSON per result or progress report to standard output.
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import sys
import time

from pkgen.system.exits import BuildError, NumericsFailed, UsageError

from . import work

TELL = 0.5  # seconds between progress reports


class _Teller:
    def __init__(self, k: int):
        self.k, self.last = k, time.monotonic()

    def __call__(self, part: float) -> bool:
        if time.monotonic() - self.last > TELL:
            self.last = time.monotonic()
            tell({"at": part})
        return False


def tell(said: dict) -> None:
    os.write(1, json.dumps(said).encode() + b"\n")


def main() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is handled by the parent process
    job, folder = pickle.load(sys.stdin.buffer)
    for line in sys.stdin.buffer:
        what, number = line.split()
        k = int(number)
        try:
            if what == b"shard":
                done = work.shard(job, folder, k, _Teller(k))
            else:
                done = work.part(job, folder, k) or {"torn": True}
            tell({"done": {"torn": bool(done.get("torn"))}})
        except OSError as error:
            tell({"disk": f"{error.filename or folder.path}: {error.strerror}"})
        except (BuildError, NumericsFailed, UsageError) as error:
            tell({"wrong": str(error)})
        except MemoryError:
            tell({"wrong": "out of memory"})


if __name__ == "__main__":
    main()
