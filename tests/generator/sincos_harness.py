"""Builds of pk/sincos.h in every variant, and its errors against mpmath."""

import ctypes
import itertools
import platform
from dataclasses import dataclass
from pathlib import Path

import mpmath
import numpy
from c_harness import ROOT, STRICT, run

TYPES = {
    "double": (numpy.float64, ctypes.c_double, 53),
    "float": (numpy.float32, ctypes.c_float, 24),
}


def targets() -> dict[str, list[str]]:
    """What to compile for: with fma() in hardware and without, as far as this machine has it."""
    if platform.machine() != "x86_64":
        return {"native": []}
    has = "fma" in Path("/proc/cpuinfo").read_text().split()
    return {"plain": []} | ({"fma": ["-mfma", "-mavx2"]} if has else {})


VARIANTS = list(itertools.product(("gcc", "clang"), targets(), ("off", "fast"), TYPES))


@dataclass
class Pair:
    """The pair of one variant."""

    library: ctypes.CDLL
    scalar: str

    @property
    def limit(self) -> float:
        self.library.limit.restype = TYPES[self.scalar][1]
        return self.library.limit()

    def __call__(self, x: numpy.ndarray) -> list[numpy.ndarray]:
        """sin x and cos x."""
        s, c = numpy.empty_like(x), numpy.empty_like(x)
        self.library.pair(ctypes.c_size_t(len(x)), *map(_pointer, (x, s, c)))
        return [s, c]

    def in_lanes(self, x: numpy.ndarray) -> list[numpy.ndarray]:
        """sin x, cos x and where they are not to be used."""
        s, c = numpy.empty_like(x), numpy.empty_like(x)
        bad = numpy.empty(len(x), dtype=f"u{x.itemsize}")
        self.library.in_lanes(ctypes.c_size_t(len(x)), *map(_pointer, (x, s, c, bad)))
        return [s, c, bad != 0]

    def every_float(self, step: int) -> tuple[int, list[float], list[float]]:
        """How many floats, the worst errors of sine and cosine, and where."""
        worst, at = (ctypes.c_double * 2)(), (ctypes.c_double * 2)()
        self.library.every.restype = ctypes.c_ulong
        return self.library.every(step, worst, at), list(worst), list(at)


def _pointer(array: numpy.ndarray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def build(
    directory: Path,
    compiler: str,
    target: str,
    contract: str,
    scalar: str,
    include: Path | None = None,
) -> Pair:
    """`include` has headers that come before the runtime's."""
    flags = ["-O3", f"-ffp-contract={contract}", "-fno-math-errno", *targets()[target]]
    flags += ["-DPK_FLOAT"] if scalar == "float" else []
    source = ROOT / "tests" / "generator" / "sincos_pair.c"
    library = directory / "pair.so"
    flags += [f"-I{path}" for path in (include, ROOT / "runtime" / "include") if path]
    run(
        *(compiler, *STRICT, *flags, "-shared", "-fPIC", source, "-o", library, "-lm"),
        cwd=directory,
    )
    return Pair(ctypes.CDLL(str(library)), scalar)


# Multiples of pi/2 to which doubles below 2^21 come nearest.
NEAREST = [29 * 2**i for i in range(16)] + [204551, 1081409, 1, 2, 3]


def arguments(scalar: str, limit: float, count: int, seed: int = 2385) -> numpy.ndarray:
    """Angles of every size up to twice the limit, both signs: spread, at the limit, beyond, next
    to multiples of pi/2 and of pi/4, subnormal."""
    real, _, bits = TYPES[scalar]
    random = numpy.random.default_rng(seed)

    def log_spread(low: float, high: float, n: int) -> numpy.ndarray:
        return numpy.exp(random.uniform(numpy.log(low), numpy.log(high), n))

    top = 2 * limit / numpy.pi
    whole = numpy.unique(numpy.r_[1:200, log_spread(1, top, count // 3).astype(int), NEAREST])
    with mpmath.workprec(200):
        near = [float(int(k) * mpmath.pi / 2) for k in whole]
        between = [float((int(k) + mpmath.mpf(1) / 2) * mpmath.pi / 2) for k in whole]
    near = numpy.array(near, dtype=real)
    tiny = float(numpy.finfo(real).tiny)
    sizes = [
        random.uniform(0, 10, count),
        log_spread(tiny, limit, count),
        random.uniform(limit / 2, limit, count),
        log_spread(limit, limit * 2.0 ** (bits / 2), count // 4),
        [limit, numpy.nextafter(real(limit), real(numpy.inf)), float(numpy.finfo(real).max)],
        tiny * 2.0 ** -numpy.arange(bits - 1),
        near,
        numpy.nextafter(near, real(0)),
        numpy.nextafter(near, real(numpy.inf)),
        between,
    ]
    x = numpy.concatenate([numpy.asarray(s, dtype=real) for s in sizes])
    return x * random.choice(numpy.array([-1, 1], dtype=real), len(x))


class Exact:
    """sin and cos of some arguments by mpmath, each as a sum of two doubles."""

    def __init__(self, x: numpy.ndarray, scalar: str) -> None:
        self.bits = TYPES[scalar][2]
        self.lowest = -1074 if scalar == "double" else -149
        self.values = []
        # 1100 bits hold any double and pi to more places than a reduction can use up.
        with mpmath.workprec(1100 if numpy.abs(x).max() > 2**100 else 250):
            for function in (mpmath.sin, mpmath.cos):
                exact = [function(mpmath.mpf(float(v))) for v in x]
                high = numpy.array([float(v) for v in exact])
                low = numpy.array([float(v - h) for v, h in zip(exact, high, strict=True)])
                self.values.append((high, low))

    def errors(self, found: list[numpy.ndarray]) -> list[numpy.ndarray]:
        """In units of the last place of the exact result."""
        errors = []
        for (high, low), got in zip(self.values, found, strict=True):
            unit = numpy.ldexp(1.0, numpy.maximum(numpy.frexp(high)[1] - self.bits, self.lowest))
            errors.append(numpy.abs((got.astype(float) - high) - low) / unit)
        return errors
