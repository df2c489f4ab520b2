"""`accuracy` in a scene: which method, at which step or tolerance, keeps it at the least cost.

trials      runs of the scene, made and measured in C
reference   the motion by the tightest runs, and how far it can be trusted
candidates  the methods that are tried, a table
search      the loosest setting of one that keeps the accuracy
race        the candidates at these settings, and the cheapest of them
whole       that one over a scene of which a part was tried
choose      all of it, of what is `Task`, to a Choice
prepared    the program by which choices are made
sample      the members of an ensemble that are tried
parts       the Choice for a scene, or one for each block of coordinates that is integrated apart
report      what is said of it
"""

from .choice import Choice
from .parts import chosen, with_choices
from .report import lines, record

__all__ = ["Choice", "chosen", "lines", "record", "with_choices"]
