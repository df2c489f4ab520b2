"""What an editor knows of the language: its words, how a text is laid out, what a name means."""
