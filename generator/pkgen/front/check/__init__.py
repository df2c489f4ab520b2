"""Turns parsed statements into a Model; reports all semantic errors of a file in one run.

The entry point is `check.check_text`. `scene_numbers` and `options_text` evaluate numbers of scenes
and of the command line by the same rules, for the packages `scenes` and `run`.
"""
