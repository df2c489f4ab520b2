"""Models whose families stay loops, each with sizes down to the smallest at which it is defined."""

from conftest import case

FPUT = case("fput")

# Sine-Gordon: a ring of pendulums, a free chain, one driven by its end.
RING = case("loop_models_ring")

LOOSE = case("loose")

DRIVEN = case("loop_models_driven")

# Inertial coupling of neighbours: M is banded; constant, and in a ring.
BEAM = case("beam")

WHEEL = case("wheel")

# Two families with units, families of parameters, a let of each member, an input.
PAIRED = case("paired")

# A cart that carries a chain: a scalar coordinate beside a family, in its inertia too.
CART = case("cart")

GRAVITY = case("loop_models_gravity")

SPIN = case("spin")

LATTICE = case("loop_models_lattice")

# Single members at the ends, in V and in T, with neighbours and without.
ENDS = case("loop_models_ends")

# A `let` sums over a variable that is another one's where it is used; one pair sum has no row side.
FIELD = case("field")

# Rods that hang from a cart, by relative angles, the first spring to a wall that moves: places and
# angles are carried along.
LINKS = case("loop_models_links")

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
HEATED = case("heated")
STATES = {"heated": (HEATED, (1, 2, 3, 8))}
