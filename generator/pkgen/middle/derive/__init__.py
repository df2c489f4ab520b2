"""A Model to its Equations: Lagrangian, constraints, first-order variables, events, switches."""
