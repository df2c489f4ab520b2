"""Robots as others write them, URDF and MJCF, as text of the language."""

COMMANDS = """
Write models
  import      ROBOT.urdf|ROBOT.xml         the bodies and joints of a robot as a model
"""
