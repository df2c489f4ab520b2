"""`pkgen fit`: parameters and start values from measured motions, by least squares.

data.py       experiments: columns of a file, in SI units
problem.py    residuals and their derivatives, exact for the numerical solution
search.py     the least-squares solution, from several starts
fitted.py     values, standard deviations, correlations, the picture of residuals
fit.py        the function that does all of it
"""

COMMANDS = """
Integrate it
  fit         MODEL.lag DATA.csv...        parameters from measured motions
"""
