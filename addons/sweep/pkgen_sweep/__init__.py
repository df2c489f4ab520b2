"""`pkgen sweep`: many members of a plan, in shards that any engine may run, and run again.

The start of a member is a pure function of the plan and its number (`sampling.py`). A shard is a
range of members; its file is complete or absent, and describes itself (`shards.py`). Parts of the
data set are divided by members alone (`parts.py`): their bytes do not depend on the engine.
"""

COMMANDS = """
Integrate it
  sweep       [MODEL.lag] [-o DIR]         many members of a plan, as Parquet
"""
