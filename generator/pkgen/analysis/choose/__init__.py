"""`accuracy` in a scene: the method and its step or tolerance that keep it at the least cost.

trials      runs of the scene, made and measured in C
reference   the motion by the tightest runs, and its error
candidates  the table of methods that are tried
search      the loosest setting of a method that keeps the accuracy
race        the cheapest candidate at these settings
whole       checks a choice, made on the first part of a scene, over the whole scene
choose      the whole procedure, from a `Task` to a `Choice`
prepared    the program that runs the trials
sample      the members of an ensemble that are tried
parts       the Choice for a scene, or for each block of coordinates that is integrated separately
report      messages about a choice
"""

from .choice import Choice
from .parts import chosen, with_choices
from .report import lines, record

__all__ = ["Choice", "chosen", "lines", "record", "with_choices"]
