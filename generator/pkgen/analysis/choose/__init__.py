"""Finds the method, with its step or tolerance, that keeps the `accuracy` of a scene at the least
cost.

trials      runs of the scene, made and measured in C
reference   the motion as computed by the tightest runs, and the error of these runs
candidates  the table of methods that are tried
search      the loosest setting (step or tolerance) of one method that keeps the accuracy
race        the cheapest candidate, if each has its loosest setting
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
