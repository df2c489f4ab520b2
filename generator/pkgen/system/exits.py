"""The exit codes of every command."""

DONE = 0
MODEL_WRONG = 1
USAGE = 2
COMPILER_FAILED = 3
NUMERICS_FAILED = 4  # The C driver returns this code too.
LEFT = 75  # The run ended with a checkpoint and can resume.
INTERRUPTED = 130


class UsageError(Exception):
    """The options of a command or the arguments of a call are invalid."""


class NumericsFailed(Exception):
    """The C driver, or a computation with it, failed; the text gives the reason."""


class BuildError(Exception):
    """No C compiler, a compiler error (the text has its messages), or an unusable cache."""
