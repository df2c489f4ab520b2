"""Command-line options that several commands share."""

from __future__ import annotations

import argparse

from ..defaults import GAUSS_RTOL, ITERATIONS, OPTIONS, RTOL, UNTIL


def of_a_motion(parser: argparse.ArgumentParser, until: str = f"{UNTIL:g}") -> None:
    """Adds the options scene, parameters, start and duration. `until` is the default duration."""
    add = parser.add_argument
    add("--scene", metavar="NAME", help="one scene of the model; options override it")
    add("--set", action="append", default=[], metavar="p=VALUE", help="a parameter or input")
    add("--start", action="append", default=[], metavar="a=VALUE", help="a coordinate or a rate")
    add("--until", metavar="T", help=f"duration (default: {until})")


def own_methods(parser: argparse.ArgumentParser) -> None:
    """Adds options that define integration methods; each option may be repeated."""
    add = parser.add_argument
    help_ = "a method by its tableau: rows of A, weights b, perhaps bhat"
    add("--tableau", action="append", default=[], metavar="FILE", help=help_)
    help_ = "a method of Verlet steps, each of a part of the step"
    add("--composition", action="append", default=[], metavar="W1,W2,…", help=help_)


def of_implicit_methods(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--iteration", choices=ITERATIONS, help="of implicit methods")
    parser.set_defaults(iteration=ITERATIONS[0])


def tolerance(parser: argparse.ArgumentParser) -> None:
    help_ = f"of an adaptive method (default {RTOL:g})"
    parser.add_argument("--rtol", metavar="R", help=help_)


def directory(parser: argparse.ArgumentParser, usual: str = "here") -> None:
    add = parser.add_argument
    add("-o", dest="directory", default=".", metavar="DIR", help=f"default: {usual}")


def canonical(parser: argparse.ArgumentParser) -> None:
    help_ = "the canonical form too: H(q, p) and its gradients"
    parser.add_argument("--canonical", action="store_true", help=help_)


def sincos(parser: argparse.ArgumentParser) -> None:
    help_ = "sine and cosine of the C library, not the inline pair"
    parser.add_argument("--libm", action="store_true", help=help_)
    help_ = "no fused multiply-add: the same bits on processors with it and without"
    parser.add_argument("--portable", action="store_true", help=help_)


def no_reduce(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--no-reduce",
        nargs="?",
        const="all",
        metavar="LIST",
        help="keep all that a scene does not need, or make all reductions but these: "
        "fold,outputs,unconnected,cyclic,apart,exact",
    )


def of_a_model(parser: argparse.ArgumentParser) -> None:
    """Adds options for compiling a model."""
    add = parser.add_argument
    add("--size", action="append", default=[], metavar="N=64", help="length of a family")
    help_ = "read a table of the model from another file"
    add("--table", action="append", default=[], metavar="ROAD=FILE", help=help_)
    add("--max-seconds", metavar="S", help="CPU time that compiling may take")
    help_ = "models and plans may name files in DIR too, besides their own folder"
    add("--allow-path", action="append", default=[], metavar="DIR", help=help_)


def unrolling(parser: argparse.ArgumentParser) -> None:
    """Adds options for writing families of coordinates as straight-line code or as loops."""
    one = parser.add_mutually_exclusive_group()
    help_ = "write families out, of any size (default: up to 16 coordinates)"
    one.add_argument("--unroll", action="store_const", const="all", help=help_)
    help_ = "keep families as loops, of any size"
    one.add_argument("--no-unroll", dest="unroll", action="store_const", const="none", help=help_)


def of_a_picture(parser: argparse.ArgumentParser, by_itself: str) -> None:
    """Adds options that select what to draw. `by_itself` describes the default in the help."""
    add = parser.add_argument
    add("--columns", metavar="a,b", help=f"these over time (default: {by_itself})")
    add("--phase", action="append", metavar="a,a'", help="phase plane; a alone: and its rate")
    add("--path", action="append", metavar="x,y", help="path in the plane; x,y,z: in space")
    add("--spectrum", metavar="a,b", help="amplitudes over frequency")
    add("--drift", action="store_true", help="how far constants come from their start")
    add("--width", type=float, metavar="MM", help="of the picture: 90, a column, or 180, a page")


def of_a_look(parser: argparse.ArgumentParser) -> None:
    """Adds options for the width, format and colours of pictures."""
    add = parser.add_argument
    add("--width", type=float, metavar="MM", help="of the picture: 90, a column, or 180, a page")
    add("--format", default="svg,png", metavar="LIST", help="of the picture: svg,png,pdf,pgf")
    add("--dark", action="store_true", help="a picture for a dark page")


def of_a_run(parser: argparse.ArgumentParser) -> None:
    of_an_integration(parser)
    add = parser.add_argument
    add(
        "-o",
        dest="output",
        metavar="FILE",
        help="FILE.csv or FILE.npy; default: standard output",
    )
    add("--plot", metavar="FILE", help="a picture too: FILE.svg, FILE.png or FILE.pdf")
    add("--report", metavar="FILE", help="one page of all that there is to say: FILE.html")
    of_a_picture(parser, "all columns")


def of_an_integration(parser: argparse.ArgumentParser) -> None:
    """Adds all options of `pkgen run` except those for its output."""
    from ..run.diagnostics import NAMES  # slow import, which `pkgen methods` does not need

    add = parser.add_argument
    of_a_motion(parser)
    add(
        "--method",
        metavar="NAME",
        help="see pkgen methods; default gauss, or dop853 for kinks (abs, min, max, step) and "
        f"for --rtol above {GAUSS_RTOL:.0e}".replace("e-0", "e-"),
    )
    own_methods(parser)
    add("--step", metavar="H", help="of a method with fixed steps; else the first step")
    add("--max-step", metavar="H", help="of an adaptive method, and of respa's inner steps")
    tolerance(parser)
    add("--atol", metavar="A", help="default: R times the scale that the motion shows")
    add("--every", metavar="DT", help="time between rows (default: a thousandth of the duration)")
    add("--units", action="store_true", help="units in the header of the CSV")
    add("--record", metavar="a,b,energy", help="only these columns, behind t")
    add("--at", metavar="EVENT", help="a row at each crossing, and by time only with --every")
    add("--ensemble", metavar="FILE", help="CSV or Parquet, a row a trajectory: starts, parameters")
    add("--threads", type=int, metavar="N", help="of an ensemble (default: all cores)")
    unrolling(parser)
    help_ = "none: constants are not watched, and their drifts not told"
    add("--watch", choices=("all", "none"), help=help_)
    of_implicit_methods(parser)
    add("--diagnose", metavar="LIST", help=f"{','.join(NAMES)}, or all")
    sincos(parser)
    no_reduce(parser)
    add("--max-steps", type=int, metavar="N")
    parser.set_defaults(**OPTIONS)


def as_of_a_run(parser: argparse.ArgumentParser) -> None:
    """Gives the command of `parser` the defaults of all options of `pkgen run`, including options
    that the command does not have."""
    of_run = argparse.ArgumentParser()
    of_a_run(of_run)
    parser.set_defaults(**vars(of_run.parse_args([])))
