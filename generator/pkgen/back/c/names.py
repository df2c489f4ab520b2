"""Makes C names from a model's names, distinct from macros, keywords and each other.

If a user includes another header before the model's, a macro of that header may have the name of a
struct member or a local variable. Names of known macros therefore get a trailing underscore in C.
The tables that a program reads at run time keep the author's spelling.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

# C99 and C++17 keywords. A model cannot use them, but a name derived from the model's may be one.
_KEYWORDS = """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t
    class compl const const_cast constexpr continue decltype default delete do double dynamic_cast
    else enum explicit export extern false float for friend goto if inline int long mutable
    namespace new noexcept not not_eq nullptr operator or or_eq private protected public register
    reinterpret_cast restrict return short signed sizeof static static_assert static_cast struct
    switch template this thread_local throw true try typedef typeid typename typeof union unsigned
    using virtual void volatile wchar_t while xor xor_eq
"""

# Most macros have names in capitals, so all names of three or more capitals get an underscore.
# _MACROS has other macros, of standard and system headers, of gcc's gnu modes and of platforms.
_CAPITALS = re.compile(
    r"(?![A-Z](_[0-9]+)+$)[A-Z][A-Z0-9_]+[A-Z0-9](f|l|q|f[0-9]+x?)?|(PRI|SCN)[a-z]\w*[^_]"
)  # The lookahead excludes names like M_0_1, which pkgen itself makes.
_MACROS = """
    I B0 HZ SP IN PI AF_DECnet PF_DECnet L_ctermid L_cuserid L_tmpnam P_tmpdir
    and and_eq bitand bitor compl not not_eq or or_eq xor xor_eq
    alignas alignof bool complex false imaginary noreturn static_assert thread_local true
    assert basename errno h_errno math_errhandling offsetof signgam stderr stdin stdout
    arm far hyper huge i386 interface linux max min mips near small sun unix vax
    d_fileno h_addr ifa_broadaddr ifa_dstaddr ifc_buf ifc_req ifr_addr ifr_bandwidth ifr_broadaddr
    ifr_data ifr_dstaddr ifr_flags ifr_hwaddr ifr_ifindex ifr_map ifr_metric ifr_mtu ifr_name
    ifr_netmask ifr_newname ifr_qlen ifr_slave msg_cbytes s6_addr s6_addr16 s6_addr32 sa_handler
    sa_sigaction sched_priority si_addr si_addr_lsb si_arch si_band si_call_addr si_fd si_int
    si_lower si_overrun si_pid si_pkey si_ptr si_status si_stime si_syscall si_timerid si_uid
    si_upper si_utime si_value sigev_notify_attributes sigev_notify_function st_atime st_ctime
    st_mtime atomic_init atomic_load_explicit atomic_store_explicit atomic_exchange_explicit
    atomic_compare_exchange_strong_explicit atomic_compare_exchange_weak_explicit
    atomic_fetch_add_explicit atomic_fetch_and_explicit atomic_fetch_or_explicit
    atomic_fetch_sub_explicit atomic_fetch_xor_explicit
"""

# Functions of <math.h> and POSIX. A local variable with such a name would hide the function.
_FUNCTIONS = """
    acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs
    fdim floor fma fmax fmin fmod frexp gamma hypot ilogb j0 j1 jn ldexp lgamma llrint llround log
    log10 log1p log2 logb lrint lround modf nan nearbyint nextafter nexttoward pow remainder remquo
    rint round scalb scalbln scalbn significand sin sincos sinh sqrt tan tanh tgamma trunc y0 y1 yn
    abs labs div rand exit abort memcpy printf main
"""

# Names of arguments, loop variables and struct members in the templates.
_OURS = """
    p t q v u w a M f momenta pdot dLdq p_q pdot_q pdot_v r_q r_v r_t out given lo hi c_ i j k n
    status bad pass sc m_out r_out v_out a_out phi_out J_out residual_out phi_size residual_size
    lambda_out off_out off_size off_rows size_t ptrdiff_t
    r_u r_p out_x out_u out_p out_d energy_d event_d switch_d start_p default_p
    canonical_d adjoint
"""
_MEMBERS = " c_ side_ factors_ inverse_ block_"  # of struct NAME_params

# The names of the versions of these functions for double, float, long double and quad.
_LIBM = " ".join(name + end for name in _FUNCTIONS.split() for end in ("", "f", "l", "q"))
FIELD_RESERVED = frozenset((_KEYWORDS + _MACROS + _MEMBERS).split())
LOCAL_RESERVED = frozenset((_KEYWORDS + _MACROS + _LIBM + _OURS).split())


class Names:
    """Allocates C identifiers: a name if it is free, else the name with underscores appended. Names
    that begin with `prefix` are reserved for the model's global symbols."""

    def __init__(
        self, reserved: frozenset[str], taken: Iterable[str] = (), prefix: str = "pk_"
    ) -> None:
        self._reserved, self._prefixes = reserved, ("pk_", prefix.lower())
        self._taken = set(taken)
        self._next: dict[str, int] = {}

    def take(self, wish: str) -> str:
        """Returns a free name: `I` becomes `I_`; names reserved by C or pkgen (`_X`, `__x`, `pk_x`)
        get an `x` in front."""
        name = re.sub(r"\W", "_", wish, flags=re.ASCII)
        if not name or name[0] in "_0123456789" or name.lower().startswith(self._prefixes):
            name = "x" + name
        while not self.is_free(name):
            name += "_"
        self._taken.add(name)
        return name

    def number(self, stem: str) -> str:
        """Returns the next free name of the form stem1, stem2, ..."""
        count = self._next.get(stem, 0) + 1
        while not self.is_free(f"{stem}{count}"):
            count += 1
        self._next[stem] = count
        self._taken.add(f"{stem}{count}")
        return f"{stem}{count}"

    def is_free(self, name: str) -> bool:
        if name in self._taken or name in self._reserved:
            return False
        return not (self._reserved and _CAPITALS.fullmatch(name))


def local_wish(name: str) -> str:
    """Returns the preferred local name of a quantity: theta1_dot for theta1', q3 for q[3], x1_3 for
    x1[3], r_x for r.x."""
    primes = len(name) - len(name.rstrip("'"))
    stem = re.sub(r"\d\[(-?\d+)\]", lambda m: m[0][0] + "_" + m[1], name.replace("'", ""))
    stem = re.sub(r"\[(-?\d+)\]", r"\1", stem).replace("-", "m").replace(".", "_")
    return stem + ("_" + "d" * (primes - 1) + "dot" if primes else "")
