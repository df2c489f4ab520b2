"""The exit codes of every command."""

DONE = 0
MODEL_WRONG = 1
USAGE = 2
COMPILER_FAILED = 3
NUMERICS_FAILED = 4  # also the code of the C driver
LEFT = 75  # ended with a checkpoint, from which the run can resume
INTERRUPTED = 130


class UsageError(Exception):
    """The options of a command or the arguments of a call are invalid."""


class NumericsFailed(Exception):
    """The C driver, or a computation with it, failed; the text is the reason."""


class BuildError(Exception):
    """There is no C compiler, or it failed (the text has its messages), or there is no cache."""
