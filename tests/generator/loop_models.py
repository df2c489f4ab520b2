"""Models whose families stay loops, each with sizes down to the smallest at which it is defined."""

from __future__ import annotations

FPUT = """\
model fput
size  N = 31                       # moving masses
param alpha = 0.25
coord q[1..N]
fixed q[0] = 0, q[N+1] = 0
kinetic   sum(q[i]'^2/2, i = 1..N)
potential sum((q[i+1]-q[i])^2/2 + alpha/3*(q[i+1]-q[i])^3, i = 0..N)
start q[i = 1..N] = sin(pi*i/(N+1))
"""

# Sine-Gordon: a ring of pendulums, a free chain, one driven by its end.
RING = """\
model ring
size N = 7
param k = 1.3 in (0, inf)
param m = 0.7 in (0, inf)
param g = 2.385
coord x[0..N-1]
periodic x
kinetic sum(m/2*x[i]'^2, i = 0..N-1)
potential sum(k/2*(x[i+1] - x[i])^2 + k/8*(x[i+2] - x[i])^2 + g*(1 - cos(x[i])), i = 0..N-1)
dissipation sum(0.1*(x[i]' - x[i-1]')^2, i = 0..N-1)
observe length = sqrt(sum((x[i+1] - x[i])^2, i = 0..N-1))
observe all = T + V - energy
start x[i = 0..N-1] = sin(2*pi*i/N), x[0]' = 0.3
"""

LOOSE = """\
model loose
size N = 5
param w = 1.7
coord x[1..N]
free x
kinetic sum(x[i]'^2/2*(1 + w*i/N), i = 1..N)
potential sum((x[i+1] - x[i])^4/4, i = 0..N) + x[1]^2*w/2 + w*x[N]
force x[1] = 0.3*sin(w*t)
force x[i = 2..N] = -0.2*x[i]'*x[i-1]
start x[i = 1..N] = 1/i
"""

DRIVEN = """\
model driven
size N = 4
param A = 0.4
param w = 1.3
coord q[1..N]
fixed q[0] = A*sin(w*t), q[N+1] = A*t^2
kinetic sum(q[i]'^2/2 + 0.3*q[i]'*q[i-1]' + 0.1*q[i]'^2*cos(q[i-1]), i = 1..N)
kinetic (q[N+1]' - q[N]')^2/7
potential sum((q[i+1] - q[i])^2/2, i = 0..N)
"""

# Inertial coupling of neighbours: M is banded; constant, and in a ring.
BEAM = """\
model beam
size N = 6
param r = 0.21 in (0, 1)
coord y[1..N]
free y[0]
fixed y[N+1] = 0.2
kinetic sum(y[i]'^2/2, i = 1..N) + sum(r*(y[i+1]' + y[i]')^2/4, i = 0..N)
potential sum((y[i+1] - y[i])^2/2, i = 0..N)
start y[i = 1..N] = 0.1*i^2
"""

WHEEL = """\
model wheel
size N = 6
param r = 0.21
coord y[1..N]
periodic y
kinetic sum(y[i]'^2/2 + r*(y[i+1]' - y[i]')^2, i = 1..N)
kinetic sum(r/3*y[i+2]'*y[i]'*cos(y[i]), i = 1..N)
potential sum((y[i+1] - y[i])^2/2 + y[i]^4, i = 1..N)
start y[i = 1..N] = 0.1*i^2, y[i = 1..N]' = cos(i)
"""

# Two families with units, families of parameters, a let of each member, an input.
PAIRED = """\
model paired
size N = 5
param m[i = 1..N] = 1 + 0.1*i [kg] in (0, inf)
param k[i = 0..N] = 3 + sin(i) [N/m] in [0, inf)
param kk[i = 1..N] = 2*k[i] [N/m]
param c = 0.5 [N*s/m]
coord x[1..N], y[1..N] [m]
input push [N]
let gap[i = 1..N] = y[i] - x[i]
fixed x[0] = 0, x[N+1] = 0
kinetic sum(m[i]/2*(x[i]'^2 + y[i]'^2), i = 1..N)
potential sum(k[i]/2*(x[i+1] - x[i])^2, i = 0..N) + sum(kk[i]/2*gap[i]^2, i = 1..N)
dissipation c/2*sum((y[i]' - x[i]')^2, i = 1..N)
force y[i = 1..N] = push*i/N
observe power = sum(y[i]'*push/N, i = 1..N)
observe force1 = k[0]*x[1]
start x[i = 1..N] = 0.1/i [m], y[N]' = 0.2
"""

# A cart that carries a chain: a scalar coordinate beside a family, in its inertia too.
CART = """\
model cart
size N = 5
param M = 2
param m = 0.3
coord X, q[1..N], phi
kinetic M/2*X'^2 + sum(m/2*(X' + q[i]')^2, i = 1..N) + phi'^2*(1 + X^2/7)/2
potential sum((q[i+1] - q[i])^2/2, i = 1..N-1) + (q[1] - phi)^2 + X^2*q[N]^2/5
observe momentum = p_X
start X = 0.3, q[i = 1..N] = 0.2*i, phi' = 1
"""

GRAVITY = """\
model gravity
size N = 4
param G = 1.1
param m[i = 1..N] = 1/i in (0, inf)
coord x[1..N], y[1..N]
kinetic sum(m[i]/2*(x[i]'^2 + y[i]'^2), i = 1..N)
potential sum(-G*m[i]*m[j]/norm([x[j] - x[i], y[j] - y[i], 0]), i = 1..N-1, j = i+1..N)
start x[i = 1..N] = cos(i), y[i = 1..N] = sin(2*i)
"""

SPIN = """\
model spin
size N = 6
param w = 0.3
coord a[1..N], s
kinetic sum(a[i]'^2/2, i = 1..N) + s'^2/2
potential sum(sum((1 - cos(a[i] - a[j] - s))/N, j = i+1..N), i = 1..N)
dissipation sum(0.1*(a[i]' - a[j]')^2, i = 1..N-1, j = i+1..N)
start a[i = 1..N] = w*i
"""

LATTICE = """\
model lattice
size N = 8
param e = 0.1
coord u[1..N], w[0..N]
fixed u[0] = 0, u[-1] = 0.1, u[N+1] = 0
kinetic sum(u[i]'^2*(1 + e*w[i]^2)/2, i = 1..N) + sum(w[i]'^2/2, i = 0..N)
kinetic e*sum(u[i]'*w[i-1]'*sin(u[i]), i = 1..N)
lagrangian -sum(exp(u[i] - u[i-1]) + (u[i-1] - u[i-2])^2, i = 1..N+1)
lagrangian -sum(w[i]^2*w[i-1]^2, i = 1..N)
start u[i = 1..N] = sin(pi*i/(N+1)), w[i = 0..N] = 0.1*i
"""

# Single members at the ends, in V and in T, with neighbours and without.
ENDS = """\
model ends
size N = 5
param k = 2
coord q[1..N], y[1..N]
kinetic q[N]'^2/3 + sum(q[i]'^2/2 + y[i]'^2/2, i = 1..N)
potential k/2*q[1]^2 + k/3*q[N]^3 + sum((q[i+1] - q[i])^2/2 + (q[i+1] - q[i])^4/4, i = 1..N-1)
potential sum(y[i]^2/2, i = 1..N) + y[1]^4/4 + k*y[N]
"""

# A `let` sums over a variable that is another one's where it is used; one pair sum has no row side.
FIELD = """\
model field
size N = 5
param e = 0.3
coord q[1..N]
let all = sum(q[i], i = 1..N)
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum(q[i]^4/4, i = 1..N) + e/N*sum(all*sin(q[i])/i, i = 1..N)
potential e*sum(i*q[j]^2, i = 1..N, j = i+1..N)
"""

# Rods that hang from a cart, by relative angles, the first spring to a wall that moves: places and
# angles are carried along.
LINKS = """\
model links
size N = 5
param g = 9.81
param m[i = 1..N] = 1 + 0.3*cos(2*i) in (0, inf)
param l[i = 1..N] = 1 + 0.2*sin(i) in (0, inf)
coord q[1..N], X
input push
fixed q[0] = 0.1*sin(t)
let a[0] = 0.2*t
let a[i = 1..N] = a[i-1] + q[i]
let r[0] = [X + push, 0, 0]
let r[i = 1..N] = r[i-1] + l[i]*[sin(a[i]), -cos(a[i]), 0.1*q[i]]
let c[i = 1..N] = (r[i-1] + r[i])/2
kinetic X'^2*(2 + cos(X)) + sum(m[i]/2*dot(c[i]', c[i]') + m[i]*l[i]^2/24*a[i]'^2, i = 1..N)
potential sum(m[i]*g*c[i].y + (q[i] - q[i-1])^2, i = 1..N) + r[N].x^2
dissipation sum(0.1*dot(r[i]', r[i]'), i = 1..N)
observe tip = r[N].x + r[N].y'
observe reach = sum(m[i]*dot(r[i], r[i]), i = 1..N)*energy
start q[i = 1..N] = 0.3*i, q[1]' = 1
"""

MODELS = {
    "fput": (FPUT, (1, 2, 3, 31, 140)),
    "ring": (RING, (1, 2, 3, 7, 70)),
    "loose": (LOOSE, (1, 2, 3, 5, 70)),
    "driven": (DRIVEN, (1, 2, 3, 6)),
    "beam": (BEAM, (1, 2, 3, 6, 30)),
    "wheel": (WHEEL, (1, 2, 3, 4, 5, 6, 15)),
    "paired": (PAIRED, (1, 2, 3, 5, 70)),
    "cart": (CART, (1, 2, 5, 12)),
    "gravity": (GRAVITY, (1, 2, 3, 7)),
    "spin": (SPIN, (1, 2, 3, 8)),
    "lattice": (LATTICE, (1, 2, 3, 8)),
    "ends": (ENDS, (1, 2, 3, 5, 70)),
    "field": (FIELD, (1, 2, 5, 12)),
    "links": (LINKS, (1, 2, 3, 20)),
}

# Which stay as they are, and a word of the reason.
_CHAIN = "size N = 4\ncoord a[1..N]\nkinetic sum(a[i]'^2/2, i = 1..N)\n"
_CARRIED = (
    "model kept\nsize N = 4\ncoord a[1..N]\nfixed a[N+1] = 0\nlet x[0] = 0\n"
    "let x[i = 1..N] = x[i-1] + {}\nkinetic sum(x[i]'^2/2 + a[i]'^2/2, i = 1..N)\n"
)
UNROLLED = {
    "signs": (
        f"model signs\n{_CHAIN}potential sum((-1)^i*a[i]^2, i = 1..N)\n",
        "a negative number to a power that varies",
    ),
    "later": (_CARRIED.format("a[i+1]"), "a later member"),
    "throughout": (_CARRIED.format("a[1]"), "a[1] throughout"),
    "rates": (_CARRIED.format("a[i]'").replace("x[i]'^2", "x[i]^2"), "made of the rate"),
    "bends": (_CARRIED.format("abs(a[i])"), "bends or jumps"),
    "beyond": (
        _CARRIED.format("a[i-1]").replace("fixed a[N+1] = 0", "free a[0]"),
        "reaches a[i - 1] beyond an end of 'a' that is free or periodic",
    ),
    "constant": (
        "model constant\ncoord a[1..3]\nkinetic sum(a[i]'^2/2, i = 1..3)\npotential a[1]^2\n",
        "length that depends on a size",
    ),
    "mirror": (
        "model mirror\nsize N = 4\ncoord a[1..N]\nkinetic sum(a[i]'^2/2, i = 1..N)\n"
        "potential sum(a[i]*a[N+1-i], i = 1..N)\n",
        "from its index",
    ),
}

# First-order variables: of each member, of all, beside a chain.
HEATED = """\
model heated
size N = 5
param k = 1.2
coord q[1..N]
state u[0..N], s
fixed q[0] = 0.1*t
free u[N+1]
kinetic sum(q[i]'^2*(2 + cos(q[i-1]))/2, i = 1..N)
potential sum((1 + u[i]^2/3 + s*u[i-1])*(q[i] - q[i-1])^2/2, i = 1..N)
dissipation sum(u[i]^2*q[i]'^2/20, i = 1..N)
force q[1] = -k*q[1]' + s*u[1]
rate u[0] = s^2 - u[0]
rate u[i = 1..N] = k*(u[i-1] - 2*u[i] + u[i+1]) - u[i]^3 + q[i]*q[i]'*s
rate s = -s*k + sum(u[i]^2*q[i]', i = 1..N)/N
"""
STATES = {"heated": (HEATED, (1, 2, 3, 8))}
