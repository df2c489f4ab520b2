"""System services: files, caches, child processes, resource limits, the C compiler, HTML pages.

The package knows nothing of models; all packages may call it.
"""
