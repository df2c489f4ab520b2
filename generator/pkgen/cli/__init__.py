"""The commands: they turn options of the command line into calls, and print the results.

Only this package prints and exits. Only `__main__` imports it.
"""
