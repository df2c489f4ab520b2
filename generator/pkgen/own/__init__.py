"""Methods that a model or the command line defines: tableau files, weights of compositions."""
