"""pkgen from Python: models as objects, runs as arrays, kernels on any number of states.

`prepare` is the road from options to a run, which the command line takes as well. Called by `cli`
and by whoever imports pkgen.
"""
