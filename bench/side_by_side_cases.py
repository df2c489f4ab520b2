"""The systems that both have: physicskit's makers and settings, of its own tests of conservation
(physicskit 0.4.0, classical/tests/test_conservation.py), and our model of the same.
"""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

EXPLICIT = ("verlet", "yoshida4", "blanes_moan6", "kahan_li8", "dop853", "gauss")
IMPLICIT = ("gauss2", "gauss4", "dop853", "gauss")


@dataclass(frozen=True)
class Case:
    name: str
    make: Callable[[], object]  # of theirs
    step: float
    steps: int
    method: str
    model: str
    words: tuple[str, ...] = ()  # --set, --start, --size of ours
    ours: tuple[str, ...] = EXPLICIT
    longest: float = 0.5  # step of ours
    offset: float = 0.0  # what their energy has besides
    starts: Callable[[], dict[str, float]] = field(default=dict)
    polar: bool = False  # ours is in r and phi, theirs in x and y
    members: int = 1

    @property
    def time(self) -> float:
        return self.steps * self.step

    def options(self, directory: Path) -> list[str]:
        every = self.time / 100
        given = [w for name, x in self.starts().items() for w in ("--start", f"{name}={x!r}")]
        found = [*self.words, *given, "--every", repr(every)]
        if self.members > 1:
            system = self.make()
            pairs = zip(map(float, system.q), map(float, system.p), strict=True)
            lines = (f"{q!r},{p!r}" for q, p in pairs)
            path = directory / "members.csv"
            path.write_text("theta,theta'\n" + "\n".join(lines) + "\n", encoding="utf-8")
            found += ["--ensemble", str(path), "--threads", "1"]
        return found

    def found(self, told: dict) -> tuple[float, float, list[float]]:
        """Drift beside their |H(0)|, H(0) as they count it, q and q' at the end."""
        if self.members > 1:
            return _of_members(told["rows"])
        report = told["report"]
        (drift,) = (d for d in report["drifts"] if d["name"] == "energy")
        energy = drift["first"] + self.offset
        end = [*report["q"], *report["v"]]
        return (
            drift["max"] * drift["scale"] / abs(energy),
            energy,
            _plane(end) if self.polar else end,
        )

    def end(self, result) -> list[float]:
        if result.q is None:
            return [float(x) for x in result.y[-1]]
        return [float(x) for x in (*result.q[-1], *result.p[-1])]

    def loop_of(self, system) -> float:
        """Seconds of the compiled loop that integrate() calls."""
        from physicskit.classical.core import integrators

        if self.method == "yoshida4":
            loop, f = integrators.yoshida4_integrate, system._force_njit
            start = (system.mass_inv, system.q.copy(), system.p.copy())
        else:
            loop, start = integrators.implicit_midpoint_integrate, (system.state.copy(),)
            f = getattr(system, "_canonical_deriv_njit", None) or system._deriv_njit
        begin = time.perf_counter()
        loop(f, *start, 0.0, self.steps, self.step)
        return time.perf_counter() - begin


def _of_members(rows: list[list[float]]) -> tuple[float, float, list[float]]:
    """Rows are member, t, theta, theta', energy: the energy is that of all."""
    total: dict[float, float] = {}
    for _, t, *_, energy in rows:
        total[t] = total.get(t, 0.0) + energy
    first = total[0.0]
    last = max(total)
    end = [row for row in rows if row[1] == last]
    drift = max(abs(x - first) for x in total.values()) / abs(first)
    return drift, first, [*(row[2] for row in end), *(row[3] for row in end)]


def _plane(end: list[float]) -> list[float]:
    r, phi, dr, dphi = end
    c, s = math.cos(phi), math.sin(phi)
    return [r * c, r * s, dr * c - r * dphi * s, dr * s + r * dphi * c]


def _systems(module: str):
    return importlib.import_module(f"physicskit.classical.systems.{module}")


def _of(module: str, name: str, *arguments: object, maker: str = "", **named: object):
    def make():
        import numpy

        system = getattr(_systems(module), name)
        taken = [numpy.array(a) if isinstance(a, list) else a for a in arguments]
        return (getattr(system, maker) if maker else system)(*taken, **named)

    return make


def _random_chain():
    import numpy

    q = numpy.random.default_rng(0).normal(0, 0.1, 16)
    return _systems("chains").HarmonicChain(q, numpy.zeros(16), k=1.0)


def _sine_gordon():
    chain = _systems("chains").SineGordonChain
    q0, p0 = chain.kink(100, center=50, width=1.0, velocity=0.2)
    return chain(n=100, q0=q0, p0=p0)


def _members_of(make: Callable[[], object], name: str) -> Callable[[], dict[str, float]]:
    return lambda: {f"{name}[{i}]": float(x) for i, x in enumerate(make().q, 1)}


_fput = _of("chains", "FPUTChain", n=32, beta=0.7, mode=1, amplitude=0.5)
MIDPOINT = "implicit_midpoint"
CASES = (
    Case(
        "projectile", _of("newtonian", "ProjectileMotion", 20.0, 45.0, g=9.81, maker="from_launch"),
        1e-3, 100_000, "yoshida4", "bench/lag/projectile.lag",
        longest=10.0, ours=("exponential", "gauss", "dop853", "gauss2"),
    ),
    Case(
        "Kepler, e = .5",
        _of("newtonian", "KeplerSystem", maker="from_orbital_elements", a=1.0, e=0.5),
        1e-3, 100_000, "yoshida4", "models/particles/kepler.lag", ("--set", "e=0.5"), longest=0.1,
    ),
    Case(
        "Kepler and .01/r^3, e = .3",
        _of("newtonian", "KeplerSystem", maker="from_orbital_elements", a=1.0, e=0.3, c_pn=0.01),
        1e-3, 100_000, "yoshida4", "models/particles/kepler_perturbed.lag",
        ("--set", "gamma=0.01"), ours=IMPLICIT, polar=True,
    ),
    Case(
        "Foucault's pendulum",
        _of("newtonian", "FoucaultPendulum", maker="from_deflection", amplitude=1.0,
            latitude_deg=48.85),
        1e-3, 100_000, MIDPOINT, "models/pendulums/foucault.lag",
        ("--set", "amplitude=1", "--set", "latitude=48.85 [deg]", "--set", "m=1",
         "--set", "turn=7.292115e-5"),
        ours=("exponential", *IMPLICIT), longest=4.0,
    ),
    Case(
        "double pendulum", _of("lagrangian", "DoublePendulum", [2.0, 1.0], [0.5, -0.3]),
        3e-5, 10_000, MIDPOINT, "models/double_pendulum.lag",
        ("--start", "theta1=2", "--start", "theta2=1", "--start", "theta1'=0.5",
         "--start", "theta2'=-0.3"),
        ours=IMPLICIT, longest=0.15,
    ),
    Case(
        "bead on a hoop", _of("lagrangian", "BeadOnRotatingHoop", 0.3, 0.0, omega=3.0),
        2.2e-5, 10_000, MIDPOINT, "models/bead_on_hoop.lag",
        ("--set", "Omega=3", "--start", "theta=0.3"), ours=IMPLICIT, longest=0.11, offset=9.81,
    ),
    Case(
        "coupled oscillators",
        _of("lagrangian", "CoupledOscillators", [0.1, -0.2, 0.15], [0.0] * 3),
        1e-4, 10_000, MIDPOINT, "models/coupled_oscillators.lag",
        ("--start", "q[1]=0.1", "--start", "q[2]=-0.2", "--start", "q[3]=0.15",
         "--start", "q[2]'=0", "--start", "q[3]'=0"),
        ours=("exponential", *EXPLICIT), longest=1.0,
    ),
    Case(
        "elastic pendulum", _of("lagrangian", "ElasticPendulum", [0.1, 0.05], [0.0, 0.0]),
        2e-5, 10_000, MIDPOINT, "models/elastic_pendulum.lag",
        ("--set", "k=39.24", "--start", "s=0.1", "--start", "theta=0.05"), ours=IMPLICIT,
        longest=0.1,
    ),
    Case(
        "heavy top",
        _of("rotations", "HeavySymmetricTop", [0.0, 0.5, 0.0], [0.0, 0.0, 20.0]),
        5e-5, 10_000, MIDPOINT, "models/heavy_top.lag",
        ("--start", "theta=0.5", "--start", "phi'=0", "--start", "psi'=20"), ours=IMPLICIT,
        longest=0.25,
    ),
    Case(
        "Hénon–Heiles", _of("hamiltonian", "HenonHeilesSystem", [0.0, 0.3], [0.3, 0.0]),
        5e-3, 100_000, "yoshida4", "models/particles/henon_heiles.lag",
        ("--start", "x=0", "--start", "y=0.3", "--start", "x'=0.3", "--start", "y'=0"), longest=1.0,
    ),
    Case(
        "200 pendulums",
        _of("hamiltonian", "PendulumSwarm", 1.0, 0.0, 0.05, 0.05, maker="from_box", n=200, seed=1),
        1e-3, 10_000, "yoshida4", "models/pendulums/pendulum.lag", ("--set", "g=1"),
        ours=("yoshida4", "blanes_moan6", "kahan_li8"), longest=1.0, members=200,
    ),
    Case(
        "harmonic chain of 16", _random_chain, 1e-2, 100_000, "yoshida4",
        "models/chains/harmonic_fixed.lag", ("--size", "N=16"), longest=1.0,
        ours=("exponential", *EXPLICIT), starts=_members_of(_random_chain, "q"),
    ),
    Case(
        "FPUT-β of 32", _fput, 5e-2, 100_000, "yoshida4", "models/chains/fput_beta.lag",
        ("--size", "N=32", "--set", "beta=0.7"), longest=1.0, starts=_members_of(_fput, "q"),
    ),
    Case(
        "sine-Gordon kink of 100", _sine_gordon, 1e-2, 100_000, "yoshida4",
        "bench/lag/sine_gordon.lag", longest=0.5,
    ),
)  # fmt: skip
