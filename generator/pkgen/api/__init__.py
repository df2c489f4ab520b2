"""The Python API: models as objects, results of runs as arrays, kernels on arrays of states.

`prepare` compiles a model and computes the settings of a run from options. `cli` and users of the
Python package call this package.
"""
