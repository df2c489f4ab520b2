"""`pkgen sweep`: integrates many trajectories (members), whose starts a plan samples.

Members run in shards, on any engine. The start of a member is a pure function of the plan and its
number (`sampling.py`). A shard is a range of members; its file is complete or absent, and has a
description (`shards.py`), so that an interrupted sweep can be resumed. The files of the data set
are divided by member numbers only (`parts.py`): their bytes do not depend on the engine.
"""

COMMANDS = """
Integrate it
  sweep       [MODEL.lag] [-o DIR]         many members of a plan, as Parquet
"""
