"""Names in C: a model's own names, kept away from macros, keywords and each other.

A macro of any header that a user may include before ours would rewrite a struct member or a
local variable, so such names get a trailing underscore in C. The tables that a program can read
at run time keep the author's spelling.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from ..indices import parted

# C99 and C++17 keywords: the language reserves them already; a name may still become one here.
_KEYWORDS = """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t
    class compl const const_cast constexpr continue decltype default delete do double dynamic_cast
    else enum explicit export extern false float for friend goto if inline int long mutable
    namespace new noexcept not not_eq nullptr operator or or_eq private protected public register
    reinterpret_cast restrict return short signed sizeof static static_assert static_cast struct
    switch template this thread_local throw true try typedef typeid typename typeof union unsigned
    using virtual void volatile wchar_t while xor xor_eq
"""

# Object-like macros of the standard and system headers, of gcc's gnu modes and of platforms.
_MACROS = """
    I NAN NULL INFINITY HUGE HUGE_VAL HUGE_VALF HUGE_VALL EOF BUFSIZ RAND_MAX CLOCKS_PER_SEC
    M_E M_LOG2E M_LOG10E M_LN2 M_LN10 M_PI M_PI_2 M_PI_4 M_1_PI M_2_PI M_2_SQRTPI M_SQRT2 M_SQRT1_2
    MAXFLOAT DOMAIN SING OVERFLOW UNDERFLOW PLOSS TLOSS X_TLOSS FP_NAN FP_INFINITE FP_ZERO
    FP_SUBNORMAL FP_NORMAL FP_ILOGB0 FP_ILOGBNAN MATH_ERRNO MATH_ERREXCEPT math_errhandling
    FLT_EPSILON DBL_EPSILON LDBL_EPSILON FLT_MAX DBL_MAX LDBL_MAX FLT_MIN DBL_MIN LDBL_MIN FLT_RADIX
    CHAR_BIT INT_MAX INT_MIN UINT_MAX LONG_MAX LONG_MIN SIZE_MAX
    linux unix i386 sun vax mips arm errno complex imaginary assert isnan isinf isfinite signbit
    stdin stdout stderr offsetof va_start va_end setjmp signgam far near small huge hyper interface
    min max PI TWO_PI HALF_PI EULER DEG_TO_RAD RAD_TO_DEG LOW HIGH INPUT OUTPUT TRUE FALSE ERROR
    IN OUT CONST DELETE SP EDOM ERANGE EILSEQ B0 B50 B75 B110 B134 B150 B200 B300 B600 SIGINT
"""

# Functions of <math.h>, POSIX included: a local variable of that name would hide them.
_FUNCTIONS = """
    acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs
    fdim floor fma fmax fmin fmod frexp gamma hypot ilogb j0 j1 jn ldexp lgamma llrint llround log
    log10 log1p log2 logb lrint lround modf nan nearbyint nextafter nexttoward pow remainder remquo
    rint round scalb scalbln scalbn significand sin sincos sinh sqrt tan tanh tgamma trunc y0 y1 yn
    abs labs div rand exit abort memcpy printf main
"""

# What the templates call arguments, loop variables and members of their own.
_OURS = """
    p t q v u w a M f momenta pdot dLdq p_q pdot_q pdot_v r_q r_v r_t out given lo hi c_ i j k n
    status bad pass sc m_out r_out v_out a_out phi_out J_out residual_out phi_size residual_size
    lambda_out
"""

FIELD_RESERVED = frozenset((_KEYWORDS + _MACROS).split()) | {"c_", "side_"}
LOCAL_RESERVED = frozenset((_KEYWORDS + _MACROS + _FUNCTIONS + _OURS).split())


class Names:
    """Hands out C identifiers: the wished name if it can be had, else with underscores."""

    def __init__(self, reserved: frozenset[str], taken: Iterable[str] = ()) -> None:
        self._reserved = reserved
        self._taken = set(taken)
        self._next: dict[str, int] = {}

    def take(self, wish: str) -> str:
        """`I` is `I_`; what C reserves for itself (`_X`, `__x`, `pk_x`) gets an `x` before it."""
        name = re.sub(r"\W", "_", wish, flags=re.ASCII)
        if not name or name[0] == "_" or name[0].isdigit() or name.lower().startswith("pk_"):
            name = "x" + name
        while name in self._reserved or name in self._taken:
            name += "_"
        self._taken.add(name)
        return name

    def number(self, stem: str) -> str:
        """The next free one of t1, t2, ..."""
        count = self._next.get(stem, 0) + 1
        while not self.is_free(f"{stem}{count}"):
            count += 1
        self._next[stem] = count
        self._taken.add(f"{stem}{count}")
        return f"{stem}{count}"

    def is_free(self, name: str) -> bool:
        return name not in self._taken and name not in self._reserved


def local_wish(name: str) -> str:
    """What a quantity is called in a kernel: theta1' is theta1_dot, q[3] is q3, x1[3] is x1_3, and
    r.x is r_x."""
    primes = len(name) - len(name.rstrip("'"))
    stem = re.sub(r"\d\[(-?\d+)\]", lambda m: m[0][0] + "_" + m[1], name.replace("'", ""))
    stem = re.sub(r"\[(-?\d+)\]", r"\1", stem).replace("-", "m").replace(".", "_")
    return stem + dots(primes)


def dots(primes: int) -> str:
    """The end of a derivative's name: _dot, _ddot, ..."""
    return "_" + "d" * (primes - 1) + "dot" if primes else ""


def family_of(name: str) -> str:
    """The declared name of a member: q for q[3], and r.x for r[3].x."""
    return parted(name)[0]
