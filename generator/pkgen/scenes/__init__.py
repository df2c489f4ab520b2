"""Scenes, the named runs in a model's file: their equations, settings and expectations.

`explain`, `analysis` and `cli` call this package.
"""
