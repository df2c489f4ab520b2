"""Back ends: each folder turns a Program into files of one kind. They do not know each other."""
