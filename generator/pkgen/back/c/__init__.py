"""From Equations to C: `lower`, then `render`."""
