"""`pkgen optimise`: parameters, starts, inputs and durations at which a motion is best.

wanted.py     the aim, what is free, what must hold, from texts
shooting.py   direct multiple shooting: motions in pieces, and their derivatives
solve.py      the nonlinear programme, by IPOPT or SciPy
optimum.py    the optimum as tables, text and a picture
optimise.py   the function that does all of it
"""

COMMANDS = """
Integrate it
  optimise    MODEL.lag                    inputs and parameters of the best motion
"""
