"""Commands of the command line: each calls pkgen with its options and prints the results.

Only this package prints text and ends the process. Only `__main__` imports it.
"""
