"""Integration methods that a model or the command line defines by tableau files or by weights."""
