"""Methods that a model or the command line brings: a tableau file, weights of a composition."""
