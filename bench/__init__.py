"""`make bench`: accuracy against cost, pkgen and its peers side by side in one run."""
