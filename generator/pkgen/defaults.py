"""The numbers of a run that nobody gives, and the bounds of those that somebody gives.

Each is defined here alone: commands, their help, the Python API and scenes read them.
"""

UNTIL = 10.0  # duration
RTOL = 1e-10
# Measured over the models: above this rtol, dop853 reaches the same error faster than gauss.
GAUSS_RTOL = 1e-5
MAX_STEPS = 1_000_000_000
ITERATIONS = ("newton", "fixed")  # of implicit methods; the first is the default
SMALLEST_RTOL = 2.0**-52  # below it steps would be rejected forever
THREADS_MOST = 1024  # a system may refuse to start more, which would abort the program

# The options of an integration that a caller may leave out, by their names in Python.
OPTIONS = {
    **dict.fromkeys(("until", "every", "step", "max_step", "rtol", "atol", "method", "record")),
    **dict.fromkeys(("at", "ensemble", "threads", "diagnose", "no_reduce", "unroll")),
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
