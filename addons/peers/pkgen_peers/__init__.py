"""Integrators of other packages in the charts of `pkgen chart`: the option --against.

peers.py      each package, and the motion as it takes it
against.py    their points and answers, measured like pkgen's own
"""
