"""Default values of the options of a run, and bounds on given values.

Commands, their help, the Python API and scenes all read them here.
"""

UNTIL = 10.0  # duration
RTOL = 1e-10
# Measured on the models: above this rtol, dop853 reaches the same error faster than gauss.
GAUSS_RTOL = 1e-5
MAX_STEPS = 1_000_000_000
ITERATIONS = ("newton", "fixed")  # iterations of implicit methods; the first is the default
SMALLEST_RTOL = 2.0**-52  # a smaller rtol would reject steps forever
THREADS_MOST = 1024  # with more threads a system may abort the program

# Defaults of the options of an integration, by their names in Python.
OPTIONS = {
    **dict.fromkeys(("until", "every", "step", "max_step", "rtol", "atol", "method", "record")),
    **dict.fromkeys(("at", "ensemble", "threads", "seed", "diagnose", "no_reduce", "unroll")),
    "iteration": ITERATIONS[0],
    "max_steps": MAX_STEPS,
    "watch": "all",
    "units": False,
    "libm": False,
    "portable": False,
}


def wrong_rtol(rtol: float) -> str:
    """Returns why no run can have this relative tolerance, or ""."""
    if rtol < SMALLEST_RTOL:
        return f"no double is that exact; the smallest 'rtol' is {SMALLEST_RTOL:.1e}"
    if rtol >= 1:
        return "an 'rtol' of 1 or more controls nothing: it is relative to what moves"
    return ""
