"""Models in which sums stand inside of expressions, and rates of states in others' equations."""

from __future__ import annotations

from conftest import case

# A potential of totals, one of them in another, products and quotients, a scalar that feels them.
MEAN = case("mean")

# Inertia that a total changes, neighbours coupled: M is a band that varies.
SWELLING = case("swelling")

# Rates of states in momenta, in forces, in other rates and in outputs, near every kind of end.
RATED = case("rated")

# No momentum has a state in it.
STILL = """
kinetic sum(q[i]'^2/2, i = 1..N) + X'^2
"""
# Sums in starts, parameters and ends: of all, of those before, in each other.
STARTED = """
model started
size N = 5
param a[i = 0..N] = 1 + sin(i) in (-9, 9)
param M = sum(a[i]^2, i = 0..N) + 1 in (0, inf)
param b[i = 1..N] = a[i]*M - sum(a[j]*a[j-1], j = 1..i)/N
param spread = sqrt(1 + sum((a[i] - sum(a[j], j = 0..N)/(N + 1))^2, i = 0..N))
const far = 0.3
coord q[1..N], X
fixed q[0] = far*sin(t)*sum(b[i], i = 1..N)/9, q[N+1] = sum(a[i], i = 0..N)/N^2
kinetic sum(b[i]^2*q[i]'^2 + q[i]'^2, i = 1..N) + M*X'^2/sum(a[i]^2 + 1, i = 0..N)
potential sum((q[i] - q[i-1])^2*spread, i = 1..N+1) + X^2*cos(X*sum(b[i], i = 1..N))
observe mean = sum(q[i], i = 1..N)/sum(a[i]^2, i = 0..N)
start q[i = 1..N] = sin(i) - sum(sin(j), j = 1..N)/N + sum(a[k]*b[i], k = 0..i-1)
start q[i = 1..N]' = sum(sum(i*j*k, j = k..N), k = 1..N)/N^4
start X = sum(sin(i)*sum(a[j], j = 0..i), i = 1..N)/sum(i, i = 1..3)
"""
# Places along the members that outputs alone have, beside a chain, a state and rates of all.
SEEN = """
model seen
size N = 5
param l[i = 1..N] = 1 + 0.1*i in (0, inf)
coord a[1..N], q[0..N], X
state u[1..N]
fixed a[0] = 0.3*t
let x[0] = X
let x[i = 1..N] = x[i-1] + l[i]*sin(a[i])
let r[0] = [X, 0, t]
let r[1] = [cos(a[0]), u[1], a[1]]
let r[i = 2..N] = r[i-1] + 0.1*r[i-2] + l[i]*[sin(a[i]), -cos(q[i-1])*u[i], x[i]]
let turned[i = 1..N] = dot(r[i] - r[i-1], r[i] - r[0]) + sum(r[j].x, j = 0..N)/N
let up[1] = turned[N]/99
let up[i = 2..N] = up[i-1]/2 + sin(turned[i]/99) + r[i].y + a[i]'*u[i]
kinetic sum(x[i]'^2 + a[i]'^2, i = 1..N) + X'^2 + sum(q[i]'^2, i = 0..N)
potential sum(cos(q[i] - q[i-1]), i = 1..N) + sum((a[i] - a[i-1])^2, i = 1..N) + X^2
rate u[i = 1..N] = a[i] - u[i]
observe tip = up[N] + x[N]
observe speed = r[N].x' + (r[1].y*r[N].z)'
observe each[i = 1..N] = r[i].y + turned[i]*up[N] + r[i-1].x'
observe reach = sqrt(1 + sum(dot(r[i], r[i])*up[i], i = 1..N)^2)
observe rate_of = sum(r[i].x, i = 1..N)'
event near: r[N].y - 0.1 either
start a[i = 1..N] = 0.3*i
"""  # One member stands throughout a sum: in V, T, D, forces, outputs, sums of pairs.
HUB = """
model hub
size N = 5
param w[i = 0..N] = 1 + 0.2*cos(i) in (0, inf)
coord q[0..N], y[1..N]
fixed y[0] = 0.2, y[N+1] = sin(t)
kinetic sum(w[i]*(1 + q[0]^2)*q[i]'^2/2, i = 0..N) + sum(y[i]'^2*(2 + cos(y[1])), i = 1..N)
potential sum(w[i]*(1 - cos(q[i] - q[0])) + (q[i] - q[i-1])^2/2*y[N], i = 1..N)
potential sum(cos(q[i] - q[j] + y[1])/N, i = 0..N-1, j = i+1..N) + sum((y[i+1] - y[i])^2, i = 0..N)
potential sum(y[i], i = 1..N)^2*q[0]/N
dissipation sum((q[i]' - q[0]')^2*(1 + y[i]^2), i = 1..N)/20
force y[i = 1..N] = sum(sin(y[j] - y[i] + q[0]'), j = 1..N)/N
observe all = sum(q[i]' - q[N]', i = 0..N)*energy
start q[i = 0..N] = 0.1*i, y[i = 1..N] = sin(i)
"""

# The same without a chain in L.
ALONE = SEEN.replace("x[i]'^2 + a[i]'^2", "a[i]'^2").replace("model seen", "model alone")
# Accelerations in outputs: of members, of ends that are given, of what a total changes, in rates.
PUSHED = """
model pushed
size N = 5
coord q[1..N], X
state u[1..N]
fixed q[0] = 0.3*sin(t)
free q[N+1]
let e[i = 1..N] = q[i+1] - q[i-1]
let z[1] = 0
let z[i = 2..N] = z[i-1] + q[i]'*u[i]
kinetic sum(q[i]'^2/2 + e[i]'^2/9, i = 1..N) + X'^2
potential sum((q[i] - q[i-1])^2, i = 1..N) + cos(sum(q[i], i = 1..N)*X)
rate u[i = 1..N] = q[i]' - u[i]
observe first = q[1]'' + X''*q[0]''
observe each[i = 1..N] = e[i]'' - u[i]'
observe power = (sum(q[i]'^2, i = 1..N)*X)'
observe bent = z[N]' + sum(q[i], i = 1..N)''
event turns: X'' either
start q[i = 1..N] = 0.2*i
"""
# Totals of a chain of links: of places, in its inertia, beside a state that its rate has.
HUNG = """
model hung
size N = 5
coord q[1..N], X
state u[1..N]
let x[0] = X
let y[0] = 0.1*t
let x[i = 1..N] = x[i-1] + sin(q[i])
let y[i = 1..N] = y[i-1] - cos(q[i])
let c = sum(x[i]*i, i = 1..N)/sum(i, i = 1..N)
let far[1] = y[1]
let far[i = 2..N] = far[i-1]*u[i] + x[i]
kinetic sum((x[i]'^2 + y[i]'^2)*(2 + sin(c))/2, i = 1..N) + X'^2
kinetic sum(u[i]^2*q[i]'^2, i = 1..N)
potential sum(y[i], i = 1..N)*cos(c) + sum((x[i] - x[N])^2 + q[i]^2, i = 1..N)/9
dissipation c'^2 + sum(x[i]'^2, i = 1..N)/9
force X = -c' + u[1]'
rate u[i = 1..N] = c - u[i] + X'
observe middle = c + far[N]'
observe energy_too = energy*c
start q[i = 1..N] = 0.1*i
"""

TOTALS = {
    "mean": (MEAN, (1, 2, 3, 6)),
    "swelling": (SWELLING, (1, 2, 4)),
    "started": (STARTED, (1, 2, 3, 7)),
    "seen": (SEEN, (2, 3, 7)),
    "pushed": (PUSHED, (2, 3, 7)),
    "hung": (HUNG, (2, 3, 6)),
    "hub": (HUB, (1, 2, 3, 7)),
    "alone": (ALONE, (2, 3, 7)),
}
RATES = {
    "rated": (RATED, (1, 2, 3, 7)),
    "still": ("\n".join(x for x in RATED.splitlines() if "kinetic" not in x) + STILL, (1, 2, 3)),
}
