"""Words of the language: clause words, reserved names, and Greek letters spelt out."""

from __future__ import annotations

import re
import unicodedata

from .table import STATEMENTS

_CLAUSES = "in rising falling either stop every at within step rtol while and or not"
# C11 and C++20 keywords, and the macros of the headers that generated C includes.
_C = """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t
    char32_t class co_await co_return co_yield compl concept const const_cast consteval constexpr
    constinit continue decltype default delete do double dynamic_cast else enum explicit export
    extern false float for friend goto if inline int long mutable namespace new noexcept not
    not_eq nullptr operator or or_eq private protected public register reinterpret_cast requires
    restrict return short signed sizeof static static_assert static_cast struct switch template
    this thread_local throw true try typedef typeid typename union unsigned using virtual void
    volatile wchar_t while xor xor_eq
    NULL NAN INFINITY HUGE_VAL EOF errno assert main size_t
"""
# Headers of C90 to C23. A model's NAME.h would hide the compiler's, since -I. is searched first.
_HEADERS = """
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal
    stdalign stdarg stdatomic stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn
    string tgmath threads time uchar wchar wctype
"""

# Name prefixes, before a '_', of other libraries. A model's C symbols begin with the model's name.
_OTHERS = {
    "the runtime": re.compile(r"(?i:pk)(_\w*)?"),
    "GSL": re.compile(r"(?i:gsl)(_\w*)?"),
    "OpenMP": re.compile(r"(?i:g?omp)(_\w*)?"),
    "C": re.compile(
        r"[US]?(BOOL|CHAR|SHRT|INT|LONG|LLONG|SIZE|PTRDIFF|WCHAR|WINT|SIG)"
        r"(MAX|PTR|_?(FAST|LEAST|ATOMIC))?(8|16|32|64)?|QUADMATH|va|argz|envz|printf|atomic(_\w*)?"
        r"|error_message|inet6_rth|malloc_usable|sched_get_priority"
    ),
}

CLAUSE_WORDS = frozenset(_CLAUSES.split())
# Words of some statements, which are words only behind a value or another such word.
BEHIND = {
    "SAMPLE": ("offset", "delay"),
    "EVENT": ("then",),
    "IMPACT": ("with", "restitution", "friction", "along", "poisson"),
    "CONTACT": ("restitution", "friction", "along", "poisson"),
    "FRICTION": ("static",),
    "MODE": ("on", "off"),
}
TABLEAU = "tableau"  # the word before the path of a tableau file
CONSTANTS = {
    "t": "the time",
    "pi": "the number pi",
    "inf": "infinity",
    "energy": "the model's energy",
}
C_WORDS = frozenset(_C.split())
C_HEADERS = frozenset(_HEADERS.split())

_LOOK_ALIKES = {"\u2206": "Delta", "\u03c2": "sigma"}  # the increment, the sigma at a word's end


def reserved(name: str) -> str:
    """Returns why a name is reserved, or "" if it can be declared."""
    if (name in STATEMENTS and not STATEMENTS[name].soft) or name in CLAUSE_WORDS:
        return "is a word of the language"
    if name in CONSTANTS:
        return f"is {CONSTANTS[name]}"
    if name in C_WORDS:
        return "has a meaning in C or C++"
    if name.startswith("__") or (name.startswith("_") and name[1:2].isupper()):
        return "is kept for the C compiler (it begins with an underscore)"
    return ""


def symbols_of(name: str) -> str:
    """Returns the library whose C symbols would clash with those of a model called `name`, or
    ""."""
    return next((whose for whose, found in _OTHERS.items() if found.fullmatch(name)), "")


def greek(character: str) -> str | None:
    """Returns a Greek letter's name, also for look-alikes and mathematical alphabets, else None."""
    spelt = _LOOK_ALIKES.get(character)
    if spelt is not None:
        return spelt
    for form in (character, unicodedata.normalize("NFKC", character)):
        words = unicodedata.name(form, "").split() if len(form) == 1 else []
        if len(words) == 4 and words[0] == "GREEK" and words[2] == "LETTER":
            spelt = words[3].lower().replace("lamda", "lambda")
            return spelt.capitalize() if words[1] == "CAPITAL" else spelt
    return None
