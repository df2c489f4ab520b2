"""The exit codes of every command."""

DONE = 0
MODEL_WRONG = 1
USAGE = 2
COMPILER_FAILED = 3
NUMERICS_FAILED = 4  # the C driver ends with it
LEFT = 75  # with a checkpoint, from which the run goes on
INTERRUPTED = 130


class UsageError(Exception):
    """The command line asks for what there is not."""


class NumericsFailed(Exception):
    """The C driver, or what was to be found with it, failed; the text is its reason."""


class BuildError(Exception):
    """No C compiler, or it refused; the text is what it said. Or no cache for what it makes."""
