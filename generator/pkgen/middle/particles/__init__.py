"""Bodies and particles: what `kinetic` of points and rotations adds to the Lagrangian."""
