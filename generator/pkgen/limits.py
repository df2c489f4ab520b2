"""What a model may ask of the compiler, in one table. Documented in docs/language.md.

A hostile file must end within a minute and within a gibibyte, with a message that says which
limit it met; an honest one never meets any.
"""

from sys import float_info

FILE_BYTES = 1_000_000  # of one model
STATEMENTS = 20_000
DEPTH = 100  # of brackets, calls, powers, signs and primes within each other
NODES = 100_000  # of all expressions as written
NAME_LENGTH = 63  # C99 promises 63 significant characters
FAMILY = 1_000_000_000  # members of a family, terms of a sum in one range
SAMPLED = 10_000  # members of a family of parameters whose defaults are evaluated; C tests all
SWARM = 10_000_000  # members of a scene's swarm or of an ensemble
XML_DEPTH = 100
XML_ELEMENTS = 200_000
ENSEMBLE_LINE = 1_000_000  # characters of a line of its file
SWEEP = 100_000_000_000  # members of a sweep
SWARM_VALUES = 50_000_000  # starts of all of them, in memory
WRITTEN = 1_000_000_000  # numbers in all rows of a run: some 20 GB
VISITS = 300_000  # of expressions while sums unroll, each time through one counted
UNROLLED = 1_000_000  # nodes of the expression graph after unrolling and differentiation
LITERAL_DIGITS = 400
LITERAL_EXPONENT = 400
EXPONENT = 1_000  # largest magnitude of a constant exponent
CONSTANT_BITS = 4_096  # of a constant's exact numerator or denominator
DIAGNOSTICS = 50  # shown of one run
DRAWN = 512  # members of a family that are drawn: of more, some at equal distances
CPU_SECONDS = 60  # of one compile: 15 times the longest of models/; --max-seconds overrides
MEMORY_BYTES = 1 << 30  # address space added while compiling


def lost(exact: object, rounded: float, what: str = "constant") -> str:
    """Why a double cannot hold a small value that is not zero, or ""."""
    if exact == 0 or abs(rounded) >= float_info.min:
        return ""
    loses = "lose digits" if rounded else "become zero"
    return f"this {what} is too small for a double: it would {loses}"
