"""Editor support for the language: its words, the layout of a text, the meaning of a name."""

COMMANDS = """
Write models
  fmt         MODEL.lag...                 spaces and columns of the text, in place
  lsp                                      what an editor asks, over standard streams
"""
