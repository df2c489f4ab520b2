"""The limits of models and runs, in one table. Documented in docs/language.md.

A hostile file must fail within a minute and within a gibibyte, with a message that names the
limit; no realistic model meets any.
"""

from sys import float_info

FILE_BYTES = 1_000_000  # of one model
STATEMENTS = 20_000
DEPTH = 100  # nesting of brackets, calls, powers, signs and primes
NODES = 100_000  # nodes of all expressions as written, before unrolling
NAME_LENGTH = 63  # C99 promises 63 significant characters
FAMILY = 1_000_000_000  # members of a family, terms of a sum in one range
SAMPLED = 10_000  # up to so many defaults of a parameter family are evaluated; the C tests all
SWARM = 10_000_000  # members of a scene's swarm or of an ensemble
XML_DEPTH = 100
XML_ELEMENTS = 200_000
ENSEMBLE_LINE = 1_000_000  # characters of a line of an ensemble's CSV file
SWEEP = 100_000_000_000  # members of a sweep
SWARM_VALUES = 50_000_000  # initial values of all members together, in memory
WRITTEN = 1_000_000_000  # numbers in all rows of a run: some 20 GB
VISITS = 300_000  # visits of expressions while sums unroll; each iteration counts
UNROLLED = 1_000_000  # nodes of the expression graph after unrolling and differentiation
LITERAL_DIGITS = 400
LITERAL_EXPONENT = 400
EXPONENT = 1_000  # largest magnitude of a constant exponent
CONSTANT_BITS = 4_096  # bits of a constant's exact numerator or denominator
DIAGNOSTICS = 50  # shown in one run
DRAWN = 512  # members of a family that are drawn; a larger one is sampled evenly
CPU_SECONDS = 60  # of one compile: 15 times the slowest of models/; --max-seconds overrides
MEMORY_BYTES = 1 << 30  # address space added while compiling


def lost(exact: object, rounded: float, what: str = "constant") -> str:
    """Returns why a double cannot hold a small nonzero value, or ""."""
    if exact == 0 or abs(rounded) >= float_info.min:
        return ""
    loses = "lose digits" if rounded else "become zero"
    return f"this {what} is too small for a double: it would {loses}"
