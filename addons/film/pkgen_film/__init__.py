"""Films of a motion, from the drawing of its model: evaluated at each frame, projected by a camera,
rasterised to MP4, WebM or GIF, or written as animated SVG.
"""

COMMANDS = """
Make something of it
  film        MODEL.lag -o FILE            a film: MP4, WebM, GIF, animated SVG
"""
