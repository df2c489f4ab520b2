"""pkgen from Python: models as objects, runs as arrays, kernels on any number of states.

`prepare` compiles a model and settles the settings of a run from options; the command line uses it
too. `cli` and users of the Python package call this package.
"""
