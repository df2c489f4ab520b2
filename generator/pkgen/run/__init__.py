"""A compiled model made a program and run: settings in, rows and a report out.

Called by `scenes`, `analysis` and `cli`. Uses `compiler` and, below it, `system`.
"""
