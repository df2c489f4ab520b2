"""The C of equations that are kept for families of any length: see lower.py."""
