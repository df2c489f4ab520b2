"""Films of a motion, by the drawing of its model: values of the drawing at each frame, projected by
a camera, drawn by a rasteriser, and written as MP4, WebM, GIF or animated SVG."""

COMMANDS = """
Make something of it
  film        MODEL.lag -o FILE            a film: MP4, WebM, GIF, animated SVG
"""
