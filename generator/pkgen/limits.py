"""The limits of models and runs, in one table, documented in docs/language.md.

A hostile file must fail within a minute and within a gibibyte, with a message that names the limit;
no realistic model reaches a limit.
"""

from sys import float_info

FILE_BYTES = 1_000_000  # size of one model file
TABLE_BYTES = 500_000_000  # size of the data file of a table
TABLE_NUMBERS = 100_000  # numbers of a table that are written in C
STATEMENTS = 20_000
PARTS = 1_000  # parts of a model, and parts of parts
DEPTH = 100  # nesting depth of brackets, calls, powers, signs and primes
NODES = 100_000  # nodes of all expressions as written, before unrolling
NAME_LENGTH = 63  # C99 promises 63 significant characters
FAMILY = 1_000_000_000  # members of a family, or terms of a sum over one range
SAMPLED = 10_000  # defaults of a parameter family that are evaluated; C tests all of them
SWARM = 10_000_000  # members of a scene's swarm or of an ensemble
XML_DEPTH = 100
XML_ELEMENTS = 200_000
ENSEMBLE_LINE = 1_000_000  # characters in a line of an ensemble's CSV file
SWEEP = 100_000_000_000  # members of a sweep
SWARM_VALUES = 50_000_000  # initial values of all members of an ensemble, in memory
WRITTEN = 1_000_000_000  # numbers in all rows of a run, about 20 GB
VISITS = 300_000  # visits of expressions while sums unroll, in all iterations
UNROLLED = 1_000_000  # nodes of the expression graph after unrolling and differentiation
LITERAL_DIGITS = 400
LITERAL_EXPONENT = 400
EXPONENT = 1_000  # largest magnitude of a constant exponent
CONSTANT_BITS = 4_096  # bits of the numerator or denominator of an exact constant
DIAGNOSTICS = 50  # errors and warnings shown in one run
DRAWN = 512  # members of a family that are drawn; of a larger one, evenly spaced members
CPU_SECONDS = 60  # one compile: 15 times the slowest of models/; see --max-seconds
MEMORY_BYTES = 1 << 30  # address space added while compiling


def lost(exact: object, rounded: float, what: str = "constant") -> str:
    """Returns why a double cannot hold the nonzero value `exact`, which is too small, or ""."""
    if exact == 0 or abs(rounded) >= float_info.min:
        return ""
    loses = "lose digits" if rounded else "become zero"
    return f"this {what} is too small for a double: it would {loses}"
