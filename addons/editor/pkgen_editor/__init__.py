"""What an editor knows of the language: its words, how a text is laid out, what a name means."""

COMMANDS = """
Write models
  fmt         MODEL.lag...                 spaces and columns of the text, in place
  lsp                                      what an editor asks, over standard streams
"""
