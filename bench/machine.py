"""What was measured on, and with what: without it no figure means anything."""

from __future__ import annotations

import datetime
import os
import platform
import subprocess
from dataclasses import dataclass
from pathlib import Path

from .models import ROOT


@dataclass(frozen=True)
class Machine:
    cpu: str
    cores: int
    vectors: str  # the widest of AVX-512, AVX2, NEON
    fma: bool
    compilers: str
    commit: str
    date: str
    load: float  # average of the last minute, at the start

    def lines(self) -> list[str]:
        fma = "with FMA" if self.fma else "without FMA"
        return [
            f"{self.cpu}, {self.cores} cores, {self.vectors}, {fma}; {self.compilers}",
            f"{self.date}, commit {self.commit}; load average {self.load:.2f} at the start",
        ]


def describe() -> Machine:
    text = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    facts = dict(
        (key.strip(), value.strip())
        for key, _, value in (line.partition(":") for line in text.splitlines())
    )
    flags = facts.get("flags", facts.get("Features", "")).split()
    vectors = "AVX-512" if "avx512f" in flags else "AVX2" if "avx2" in flags else "NEON"
    if vectors == "NEON" and "asimd" not in flags:
        vectors = "no wide vectors"
    return Machine(
        cpu=facts.get("model name", platform.processor() or platform.machine()),
        cores=os.cpu_count() or 1,
        vectors=vectors,
        fma="fma" in flags or "asimd" in flags,
        compilers=", ".join(filter(None, map(_version, ("gcc", "clang")))),
        commit=_output(["git", "-C", str(ROOT), "describe", "--always", "--dirty"]),
        date=datetime.date.today().isoformat(),
        load=os.getloadavg()[0],
    )


def _version(compiler: str) -> str:
    number = _output([compiler, "-dumpfullversion"]) or _output([compiler, "-dumpversion"])
    return f"{compiler} {number}" if number else ""


def _output(command: list[str]) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=30)
    except OSError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
