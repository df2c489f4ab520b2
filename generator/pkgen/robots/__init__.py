"""Robots as others write them, URDF and MJCF, as text of the language."""
