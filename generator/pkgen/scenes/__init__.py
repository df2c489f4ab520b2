"""Scenes: the equations that a scene needs, settings of its run, and its expectations.

`explain`, `analysis` and `cli` call this package.
"""
