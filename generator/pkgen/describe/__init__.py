"""The description of a model as data (`pkgen describe`), read by live pages, films and exports:
names, units, bounds, starts, methods, drawings. The schema is docs/dev/describe.md.
"""
