"""Editor support for the modelling language: formatting, analysis of names, language server."""

COMMANDS = """
Write models
  fmt         MODEL.lag...                 spaces and columns of the text, in place
  lsp                                      what an editor asks, over standard streams
"""
