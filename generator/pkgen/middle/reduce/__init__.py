"""Reduces equations to fewer coordinates without changing the recorded outputs."""
