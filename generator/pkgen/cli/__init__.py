"""The commands: options of the command line to calls, results to the terminal.

Only this folder prints and exits. Nothing imports it but `__main__`.
"""
