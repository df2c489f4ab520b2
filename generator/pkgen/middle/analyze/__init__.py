"""Proves facts about equations: constant or affine parts, symmetries, conserved quantities."""
