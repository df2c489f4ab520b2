"""Statements to a Model: names, kinds, bounds, indices and units, all errors of a file in one run.

`check.check_text` is the entrance. `scene_numbers` and `options_text` evaluate numbers of scenes
and of the command line by the same rules; `scenes` and `run` call them.
"""
