"""Finds sample states at which equations are evaluated, and states at which they are singular."""
