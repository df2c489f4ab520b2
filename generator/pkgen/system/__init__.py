"""The system: files, caches, child processes, limits of memory, the C compiler, HTML pages.

The package knows nothing of models. All packages may call it.
"""
