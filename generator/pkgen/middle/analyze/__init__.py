"""Facts and proofs of equations: what is constant or affine, symmetries, what is conserved."""
