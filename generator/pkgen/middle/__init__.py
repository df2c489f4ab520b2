"""From a Model to its Equations and facts: `derive`, `analyze`, `reduce`."""
