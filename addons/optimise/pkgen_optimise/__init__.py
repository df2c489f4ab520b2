"""`pkgen optimise`: parameters, starts, inputs and durations at which a motion is best.

problem.py    the objective, unknowns and constraints, from texts
shooting.py   direct multiple shooting: intervals of a motion, and their derivatives
solve.py      the nonlinear programme, by IPOPT or SciPy
optimum.py    the optimum as tables, text and a picture
optimise.py   the function that does all of it
"""

COMMANDS = """
Integrate it
  optimise    MODEL.lag                    inputs and parameters of the best motion
"""
