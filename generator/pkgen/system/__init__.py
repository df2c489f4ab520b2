"""The machine: files, caches, child processes, limits of memory, the C compiler, pages of HTML.

Knows nothing of models. Everything may call it.
"""
