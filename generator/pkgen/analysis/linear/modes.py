"""The modes of small motions about an equilibrium, u = Re(shape exp(lambda t)) with lambda = growth
+ i frequency, sorted from the fastest. u is the displacement from the equilibrium.

Let p = dL/dv be the momenta, pdot = dL/dq + forces their derivatives, and M = dp/dv. The index c
means the cyclic coordinates, whose momenta are constant (Routh), and n the other coordinates, which
obey M u'' + C u' + K u = 0 with

M = M_nn + M_nc R, C = D_nn + M_nc S + D_nc R, K = -F_nn + D_nc S, D = dp/dq - F', F = d(pdot)/dq,
F' = d(pdot)/dv, u_c' = R u' + S u, R = -M_cn/M_cc, S = -(dp/dq)_cn/M_cc

With first-order variables or constraints, the modes are those of z' = A z. The vector z holds the
displacements of coordinates and first-order variables, then those of the coordinates' rates, as far
as a rate depends on them. It is restricted to the tangent space of the constraints.

References: L. Meirovitch, Methods of Analytical Dynamics, ch. 6; J. Marsden, T. Ratiu, Introduction
to Mechanics and Symmetry, 8.9.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cmp_to_key

import numpy
from numpy import linalg

from .rest import ZERO, Mode
from .symmetries import Symmetry
from .system import System

Moving = tuple[float, Symmetry]

NATURAL = 1e-12  # a smaller C, or asymmetry of K, relative to the equations' terms, is round-off
DEPENDENT = 1e-9  # a singular value below this part of the largest counts as 0
ROUNDED = 1e-13  # an entry of A below this part of the largest entry of its block becomes 0
BESIDE = 6e-6  # relative step of numerical derivatives
TIED = 1e-9  # relative difference of equal rates
SAME = 1e-2  # relative difference of lambda that shows a spurious mode


def modes(
    system: System, state: numpy.ndarray, moving: Sequence[Moving] = ()
) -> tuple[str, list[Mode]]:
    """Returns the status and the modes; without modes if the status is not PK_DONE. The state moves
    along the symmetries `moving`, each with its speed; displacements along them are no modes."""
    try:
        if system.n > system.m or system.given["constraints"] or moving:
            found = _first_order(system, state, moving)
        else:
            found = _of_coordinates(system, state)
    except linalg.LinAlgError:
        return "PK_SINGULAR_MASS", []
    if found is None:
        return "PK_REFUSED", []
    return "PK_DONE", sorted(found, key=cmp_to_key(lambda a, b: _first(b, a) - _first(a, b)))


def settled(
    system: System,
    state: numpy.ndarray,
    error: numpy.ndarray,
    moving: Sequence[Moving] = (),
) -> tuple[str, list[Mode]]:
    """Returns the status and the modes, with lambda = 0 for spurious modes. `error` estimates the
    error of the equilibrium `state`. If linear terms vanish at the exact equilibrium, their values
    at `state` are proportional to this error. Therefore a mode is spurious if its lambda changes
    when `state` is moved by `error`."""
    status, found = modes(system, state, moving)
    by_rate = numpy.arange(system.n) >= system.m
    by_rate[system.given["cyclic"]] = True
    moved = state + numpy.concatenate([error * ~by_rate, error * by_rate])
    known, others = modes(system, moved, moving)
    if known != "PK_DONE":
        return status, found
    beside = numpy.array([m.value for m in others])
    return status, [
        m if (abs(m.value - beside) <= SAME * m.rate).any() else Mode(0.0, 0.0, m.re, m.im)
        for m in found
    ]


def _first(a: Mode, b: Mode) -> bool:
    """Whether mode a precedes b: it is faster, or as fast with more growth."""
    tie = TIED * b.rate
    return a.rate > b.rate + tie or (a.rate > b.rate - tie and a.growth > b.growth + tie)


def _mode(value: complex, shape: numpy.ndarray, free: numpy.ndarray) -> Mode:
    """Returns a mode. Its shape is scaled so that the largest of the components marked in `free` is
    1."""
    sizes = abs(shape) * free
    lead = int((sizes >= sizes.max() / (1 + TIED)).argmax())
    shape = shape / shape[lead] if shape[lead] else shape
    re, im = (tuple(map(float, part)) for part in (shape.real, shape.imag))
    return Mode(float(value.real), float(value.imag), re, im)


def _cleared(values: numpy.ndarray) -> numpy.ndarray:
    """Sets real and imaginary parts that are small relative to the largest modulus to 0."""
    least = ZERO * abs(values).max(initial=0.0)
    re, im = (numpy.where(abs(x) <= least, 0.0, x) for x in (values.real, values.imag))
    return re + 1j * im


def _of_coordinates(system: System, state: numpy.ndarray) -> list[Mode] | None:
    n, c = system.n, system.idle
    f = ~c
    derivatives = system.kernel("momentum jacobian", 0.0, state)
    M = system.kernel("mass", 0.0, state).reshape(-1, n, n)
    if not derivatives.size or not M.size:
        return None
    (M,), (P, F, G) = M, derivatives.reshape(3, n, n)
    linalg.cholesky(M)  # M is definite
    inner, D = numpy.ix_(c, c), P - G
    across, back, own = numpy.ix_(c, f), numpy.ix_(f, c), numpy.ix_(f, f)
    R, S = (-linalg.solve(M[inner], x[across]) for x in (M, P))
    mass = M[own] + M[back] @ R
    damping = D[own] + M[back] @ S + D[back] @ R
    stiffness = -F[own] + D[back] @ S

    def shaped(value: complex, u: numpy.ndarray) -> Mode:
        shape = numpy.zeros(n, complex)
        shape[f] = u
        if value:
            shape[c] = R @ u + S @ u / value
        return _mode(value, shape, f)

    most = abs(stiffness).max(initial=0.0)
    natural = abs(damping).max(initial=0.0) <= NATURAL * (most * abs(mass).max(initial=0.0)) ** 0.5
    if natural and (abs(stiffness - stiffness.T) <= NATURAL * most).all():
        root = linalg.inv(linalg.cholesky(mass))
        squares, shapes = linalg.eigh(root @ stiffness @ root.T)
        values = _cleared(numpy.sqrt(-squares + 0j))
        both = zip(values, (root.T @ shapes).T, strict=True)
        pairs = (([1j * x.imag] if x.imag else [x, -x], u) for x, u in both)
        return [shaped(x, u) for some, u in pairs for x in some]
    zero, one = numpy.zeros_like(mass), numpy.eye(len(mass))
    A = numpy.block([[zero, one], [-linalg.solve(mass, stiffness), -linalg.solve(mass, damping)]])
    values, shapes = linalg.eig(A)
    values = _cleared(values)
    return [shaped(x, u[: len(mass)]) for x, u in zip(values, shapes.T, strict=True) if x.imag >= 0]


def _reduced(
    system: System, state: numpy.ndarray, moving: Sequence[Moving]
) -> tuple[numpy.ndarray, numpy.ndarray, int]:
    """Returns a basis T of the displacements z that are free, without cyclic coordinates; A in this
    basis; the number of its eigenvalues that are 0 since momenta are constant."""
    n, m, free = system.n, system.m, ~system.idle
    among = numpy.array([*numpy.flatnonzero(free), *range(n, n + m)])
    A = in_frame(system, system.linearised(0.0, state), moving)
    A = A[numpy.ix_(among, among)]
    if not numpy.isfinite(A).all():
        raise linalg.LinAlgError
    T = numpy.eye(len(among))
    if system.bound:
        T, A = _tangent(system, state, among, A)
    if moving and T.size:
        g = numpy.zeros((len(moving), 2 * n))
        g[:, system.used] = [s.at(state[system.used]) for _, s in moving]
        along = T.T @ g[:, system.unknowns_first[among]].T
        left_out = null_space(along.T)
        T, A = T @ left_out, left_out.T @ A @ left_out
    return T, A, int(system.idle[:m].sum()) + len(moving)


def eigenvalues(
    system: System, state: numpy.ndarray, moving: Sequence[Moving] = ()
) -> numpy.ndarray:
    """Returns all eigenvalues, not cleared of round-off, without those of constant momenta."""
    _, A, left = _reduced(system, state, moving)
    values = linalg.eigvals(A)
    return values[numpy.argsort(abs(values))][left:]


def _first_order(
    system: System, state: numpy.ndarray, moving: Sequence[Moving]
) -> list[Mode] | None:
    n, free = system.n, ~system.idle
    T, A, left = _reduced(system, state, moving)
    if not T.size:
        return None
    values, shapes = linalg.eig(A)
    values = _cleared(values)
    zeros = numpy.flatnonzero(values == 0)[:left]
    found = []
    for k in numpy.flatnonzero(values.imag >= 0):
        if k not in zeros:
            shape = numpy.zeros(n, complex)
            shape[free] = (T @ shapes[:, k])[: free.sum()]
            found.append(_mode(values[k], shape, free))
    return found


def in_frame(system: System, A: numpy.ndarray, moving: Sequence[Moving]) -> numpy.ndarray:
    """Returns the matrix A of z' = A z in the frame that moves along symmetries."""
    place = {number: k for k, number in enumerate(system.used)}
    order = [place[number] for number in system.unknowns_first]
    return A - sum(speed * s.G[numpy.ix_(order, order)] for speed, s in moving)


def kept(system: System, state: numpy.ndarray) -> numpy.ndarray:
    """Returns the derivatives by z (see above) of all functions that stay 0 during a motion: phi(q)
    of each holonomic constraint phi = 0, J v + j0 of each constraint on the rates v, and (|Q|^2 -
    1)/2 of each quaternion Q. A rotation of a body by a small vector d adds Q (0, d)/2 to Q."""
    n, m, turning = system.n, system.m, system.turning
    h, c, first = system.given["holonomic"], system.given["constraints"], m + turning
    C = numpy.zeros((h + c + turning // 3, n + m))
    if c:
        J = system.kernel("constraint jacobian", 0.0, state).reshape(c, n)
        C[:h, :m] = J[:h, :m]
        C[h : h + c, n:] = J[:, :m]
        places = [*range(m), *range(first, n)]
        most = abs(state[:m]).max(initial=0.0) or 1.0
        sizes = [most if j < m else max(1.0, abs(state[n + j])) for j in places]
        steps = BESIDE * numpy.array(sizes)
        by = numpy.zeros((len(places), 2 * n))
        by[range(len(places)), [j if j < m else n + j for j in places]] = steps
        ends = system.kernel("constraint rates", 0.0, numpy.concatenate([state + by, state - by]))
        above, below = numpy.split(ends, 2)
        C[h : h + c, places] = (above - below).T / (2 * steps)
        C[h : h + c, m:first] = J[:, m:first]
    for r in range(turning // 3):
        at = slice(first + 4 * r, first + 4 * r + 4)
        w, x, y, z = system.v(state)[at]
        C[h + c + r, at] = w, x, y, z
        if h:
            product = numpy.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
            C[:h, at] = 2 * J[:h, m + 3 * r : m + 3 * r + 3] @ product.T
    return C


def _tangent(
    system: System, state: numpy.ndarray, among: numpy.ndarray, A: numpy.ndarray
) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Returns an orthonormal basis of the null space of kept(), and A in this basis. A has four
    blocks: derivatives of positions and of rates, by positions and by rates. Entries that are
    round-off relative to their block are set to 0, since the eigenvalues of a free motion, which
    are 0, would become the square root of round-off."""
    C = kept(system, state)[:, among]
    h, c = system.given["holonomic"], system.given["constraints"]
    rate = (among >= system.n) | ((among >= system.m) & (among < system.m + system.turning))
    mixed = (C[h : h + c][:, ~rate] != 0).any()  # whether J v + j0 depends on positions
    columns, kinds = [], []
    for kind in (0, 1) if not mixed else (-1,):
        some = numpy.flatnonzero((rate == kind) | mixed)
        free = null_space(C[:, some])
        basis = numpy.zeros((len(among), free.shape[1]))
        basis[some] = free
        columns.append(basis)
        kinds += [kind] * free.shape[1]
    T = numpy.concatenate(columns, 1)
    found = T.T @ A @ T
    if not mixed:
        for i, j in numpy.ndindex(2, 2):
            most = abs(A[numpy.ix_(rate == i, rate == j)]).max(initial=0.0)
            block = numpy.ix_(numpy.array(kinds) == i, numpy.array(kinds) == j)
            found[block] = numpy.where(abs(found[block]) <= ROUNDED * most, 0.0, found[block])
    return T, found


def null_space(C: numpy.ndarray) -> numpy.ndarray:
    """Returns an orthonormal basis, as columns, of all x with C x = 0."""
    sizes = linalg.norm(C, axis=1)
    rows = C[sizes > 0] / sizes[sizes > 0][:, None]
    if not rows.size:
        return numpy.eye(C.shape[1])
    _, s, v = linalg.svd(rows)
    return v[int((s > DEPENDENT * s[0]).sum()) :].T
