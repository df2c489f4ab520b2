"""`pkgen sweep`: many members of a plan, in shards that any engine may run, and run again.

A member is a pure function of the plan and its number (`starts.py`). A shard is a range of members;
its file is written whole or not at all, and says what it holds (`shards.py`). Parts of the data set
are cut by members alone (`parts.py`), so that their bytes do not tell who ran what.
"""

COMMANDS = """
Integrate it
  sweep       [MODEL.lag] [-o DIR]         many members of a plan, as Parquet
"""
