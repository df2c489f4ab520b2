"""Derivatives of runs by parameters, starts and inputs, exact for the numerical solution."""
