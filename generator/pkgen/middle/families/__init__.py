"""Derives the equations of families of coordinates q[1..N] once for a general member q[m], so that
the C code has loops over members and is valid for any N."""
