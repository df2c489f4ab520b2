"""Derivatives of runs by parameters, starts and inputs, through the very steps of a run."""
