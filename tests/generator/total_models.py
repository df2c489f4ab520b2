"""Models in which sums stand inside of expressions, and rates of states in others' equations."""

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
STARTED = case("started")
# Places along the members that outputs alone have, beside a chain, a state and rates of all.
SEEN = case("seen")
# One member stands throughout a sum: in V, T, D, forces, outputs, sums of pairs.
HUB = case("hub")

# The same without a chain in L.
ALONE = SEEN.replace("x[i]'^2 + a[i]'^2", "a[i]'^2").replace("model seen", "model alone")
# Accelerations in outputs: of members, of ends that are given, of what a total changes, in rates.
PUSHED = case("pushed")
# Totals of a chain of links: of places, in its inertia, beside a state that its rate has.
HUNG = case("total_models_hung")

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
