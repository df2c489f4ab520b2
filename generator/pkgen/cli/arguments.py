"""Options that several commands have, so that each means the same everywhere."""

from __future__ import annotations

import argparse


def of_a_motion(parser: argparse.ArgumentParser, until: str) -> None:
    """Which motion of the model; `until` is what its duration is by default."""
    add = parser.add_argument
    add("--scene", metavar="NAME", help="one scene of the model; options override it")
    add("--set", action="append", default=[], metavar="p=VALUE", help="a parameter or input")
    add("--start", action="append", default=[], metavar="a=VALUE", help="a coordinate or a rate")
    add("--until", metavar="T", help=f"duration (default: {until})")


def of_implicit_methods(parser: argparse.ArgumentParser) -> None:
    kinds = ("newton", "fixed")
    parser.add_argument("--iteration", choices=kinds, default="newton", help="of implicit methods")


def directory(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", dest="directory", default=".", metavar="DIR", help="default: here")
