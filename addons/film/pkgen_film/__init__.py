"""Films of a motion from what the model says is drawn: the numbers of its drawing at each frame,
seen by a camera, drawn by a rasteriser, and written as MP4, WebM, GIF or animated SVG."""

COMMANDS = """
Make something of it
  film        MODEL.lag -o FILE            a film: MP4, WebM, GIF, animated SVG
"""
