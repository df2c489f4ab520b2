"""Integrators of other packages in the charts of `pkgen chart`: the option --against.

peers.py      the packages, and the initial value problem in the form that they take
against.py    measures their error and cost like those of pkgen's methods
"""
