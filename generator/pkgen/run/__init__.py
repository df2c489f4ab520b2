"""Builds a compiled model and runs it: settings in, rows and a report out.

`scenes`, `analysis` and `cli` call this package. It uses `compiler` and `system`.
"""
