"""Points at which equations are evaluated, and where they are singular."""
