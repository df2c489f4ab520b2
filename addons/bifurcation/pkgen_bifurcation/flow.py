"""The motion of a model as z' = f(t, z), with the derivatives of f."""

from __future__ import annotations

import numpy

from pkgen.analysis.linear.system import System
from pkgen.system.exits import UsageError

from .family import Family


class Flow:
    """The motion z' = f(t, z), z = (coordinates, first-order variables, rates) without unknowns on
    which no rate depends."""

    def __init__(self, family: Family):
        system = family.first
        if system.bound:
            raise UsageError("--orbit is of models without constraints and rotations")
        n, m = system.n, system.m
        free = ~system.idle
        self.family = family
        self.among = numpy.array([*numpy.flatnonzero(free), *range(n, n + m)])
        self.where = system.unknowns_first[self.among]
        self.count = len(self.among)
        self.forced = not system.is_steady()
        self.conservative = bool(system.given["conservative"]) and not system.by_norm

    def states(self, system: System, z: numpy.ndarray) -> numpy.ndarray:
        found = numpy.tile(system.begun, (*z.shape[:-1], 1))
        found[..., self.where] = z
        return found

    def rates(self, system: System, t: numpy.ndarray, z: numpy.ndarray) -> numpy.ndarray:
        states = self.states(system, z)
        a = system.kernel("acceleration", t, states)
        n, m = system.n, system.m
        whole = numpy.concatenate([states[:, n : n + m], a[:, m:], a[:, :m]], 1)
        return whole[:, self.among]

    def jacobian(self, system: System, t: numpy.ndarray, z: numpy.ndarray) -> numpy.ndarray:
        """Returns the derivatives of rates() by z."""
        n, m = system.n, system.m
        by = system.kernel("jacobian", t, self.states(system, z)).reshape(-1, 2, n, n)
        full = numpy.zeros((len(z), n + m, n + m))
        full[:, range(m), range(n, n + m)] = 1
        rows = numpy.array([*range(m, n), *range(m)])
        full[:, m:, :m] = by[:, 0, rows][:, :, :m]
        full[:, m:, [*range(n, n + m), *range(m, n)]] = by[:, 1, rows]
        return full[numpy.ix_(range(len(z)), self.among, self.among)]

    def energies(self, system: System, z: numpy.ndarray) -> numpy.ndarray:
        return system.kernel("energy", 0.0, self.states(system, z))[:, 0]
