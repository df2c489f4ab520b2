"""The compiler's middle end: derives the equations of a model, proves facts about them, and reduces
them."""
