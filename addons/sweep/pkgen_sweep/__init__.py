"""`pkgen sweep`: integrates many trajectories (members), whose starts a plan samples.

A shard is a range of members that are integrated as one task, by one of several engines (processes
of this machine, Dask, Ray, Slurm). The start of a member is a pure function of the plan and the
member's number (`sampling.py`). The file of a shard is complete or absent, and has a description
(`shards.py`), so that an interrupted sweep can be resumed. The files of the data set are divided
by member numbers only (`parts.py`), so that their bytes do not depend on the engine.
"""

COMMANDS = """
Integrate it
  sweep       [MODEL.lag] [-o DIR]         many members of a plan, as Parquet
"""
