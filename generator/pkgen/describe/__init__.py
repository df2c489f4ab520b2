"""A model as data (`pkgen describe`): names, units, bounds, starts, methods, drawings. Live pages,
films and exports read only this description. The schema is docs/dev/describe.md."""
