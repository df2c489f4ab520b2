"""Converts robots in URDF and MJCF to models in .lag."""

COMMANDS = """
Write models
  import      ROBOT.urdf|ROBOT.xml         the bodies and joints of a robot as a model
"""
