"""Command-line options that several commands share."""

from __future__ import annotations

import argparse

from ..defaults import GAUSS_RTOL, ITERATIONS, OPTIONS, RTOL, UNTIL

WIDTH = "--width float:MM of the picture: 90, a column, or 180, a page"


def rows(parser: argparse.ArgumentParser, table: str) -> None:
    """Adds options, one a line: its flag, the name of its value, its help. The name is - for none;
    it ends with + if the option may be repeated, and may begin with the value's type."""
    for line in table.strip().split("\n"):
        flag, value, help_ = line.split(maxsplit=2)
        kind, _, name = value.rpartition(":")
        how: dict = {"action": "store_true"} if value == "-" else {"metavar": name.rstrip("+")}
        how |= {"action": "append", "default": []} if value.endswith("+") else {}
        how |= {"type": {"int": int, "float": float}[kind]} if kind else {}
        parser.add_argument(flag, help=help_, **how)


def of_a_state(parser: argparse.ArgumentParser) -> None:
    """Adds the options scene, parameters and start."""
    text = """
        --scene  NAME      one scene of the model; options override it
        --set    p=VALUE+  a parameter or input
        --start  a=VALUE+  a coordinate or a rate
    """
    rows(parser, text)


def of_a_motion(parser: argparse.ArgumentParser, until: str = f"{UNTIL:g}") -> None:
    """Adds the options of a state and of the duration. `until` is the default duration."""
    of_a_state(parser)
    rows(parser, f"--until  T  duration (default: {until})")


def own_methods(parser: argparse.ArgumentParser) -> None:
    """Adds options that define integration methods; each option may be repeated."""
    text = """
        --tableau      FILE+     a method by its tableau: rows of A, weights b, perhaps bhat
        --composition  W1,W2,…+  a method of Verlet steps, each of a part of the step
    """
    rows(parser, text)


def of_implicit_methods(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--iteration", choices=ITERATIONS, help="of implicit methods")
    parser.set_defaults(iteration=ITERATIONS[0])


def tolerance(parser: argparse.ArgumentParser) -> None:
    rows(parser, f"--rtol R of an adaptive method (default {RTOL:g})")


def directory(parser: argparse.ArgumentParser, usual: str = "here") -> None:
    add = parser.add_argument
    add("-o", dest="directory", default=".", metavar="DIR", help=f"default: {usual}")


def canonical(parser: argparse.ArgumentParser) -> None:
    rows(parser, "--canonical - the canonical form too: H(q, p) and its gradients")


def sincos(parser: argparse.ArgumentParser) -> None:
    rows(parser, "--libm - sine and cosine of the C library, not the inline pair")
    help_ = "no fused multiply-add: the same bits on processors with it and without"
    rows(parser, f"--portable - {help_}")


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
    text = """
        --size         N=64+       length of a family
        --table        ROAD=FILE+  read a table of the model from another file
        --max-seconds  S           CPU time that compiling may take
        --allow-path DIR+ models and plans may name files in DIR too, besides their own folder
    """
    rows(parser, text)


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
    rows(parser, WIDTH)


def of_a_look(parser: argparse.ArgumentParser) -> None:
    """Adds options for the width, format and colours of pictures."""
    rows(parser, WIDTH)
    add = parser.add_argument
    add("--format", default="svg,png", metavar="LIST", help="of the picture: svg,png,pdf,pgf")
    add("--dark", action="store_true", help="a picture for a dark page")


def of_a_run(parser: argparse.ArgumentParser) -> None:
    of_an_integration(parser)
    add = parser.add_argument
    add("-o", dest="output", metavar="FILE", help="FILE.csv or FILE.npy; default: standard output")
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
    text = f"""
        --step      H           of a method with fixed steps; else the first step
        --max-step  H           of an adaptive method, and of respa's inner steps
        --rtol      R           of an adaptive method (default {RTOL:g})
        --atol      A           default: R times the scale that the motion shows
        --every     DT          time between rows (default: a thousandth of the duration)
        --units     -           units in the header of the CSV
        --record    a,b,energy  only these columns, behind t
        --at        EVENT       a row at each crossing, and by time only with --every
        --ensemble  FILE        CSV or Parquet, a row a trajectory: starts, parameters
        --threads   int:N       of an ensemble (default: all cores)
        --seed      int:N       of the noise (default: 0)
    """
    rows(parser, text)
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
