"""What a scene asks of a model: the equations it needs, settings of a run, what it expects.

Called by `explain`, `analysis` and `cli`.
"""
