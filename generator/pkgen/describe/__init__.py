"""A model as data (`pkgen describe`): names, units, bounds, starts, methods, drawings. Live pages,
films and exports read this and nothing else of a model. The schema is docs/dev/describe.md."""
