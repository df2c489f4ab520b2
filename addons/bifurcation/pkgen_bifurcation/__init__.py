"""`pkgen continue`: equilibria and periodic orbits along a parameter, and where they change.

A problem (`equilibria.py`, `orbits.py`, `returns.py`) has the equations of its solutions, their
derivatives and the eigenvalues of small motions. `follow.py` follows the solutions of any problem.
"""

COMMANDS = """
Judge a motion
  continue    MODEL.lag --free p=FROM:TO   equilibria and orbits along a parameter
"""


def branches(model, free, range, **more):
    """Returns the branches of a pkgen.Model, as `pkgen continue`: a branches.Branches. `more` are
    start, inputs, orbit, period, section and close, as the options. Raises UsageError,
    ModelError."""
    from .command import of_model

    return of_model(model, free, range, **more)
