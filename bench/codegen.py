"""C from SymPy by its own `cse` and `ccode`: for the peers, for the reference, for the kernels."""

from __future__ import annotations

import sympy as sp
from sympy.printing.c import C99CodePrinter

from .models import Model, equations


class _Printer(C99CodePrinter):
    """Small powers as products, as any author of C would have them."""

    def _print_Pow(self, expr):
        base, exponent = expr.as_base_exp()
        if exponent.is_Integer and 2 <= int(exponent) <= 4:
            text = self.parenthesize(base, sp.printing.precedence.PRECEDENCE["Mul"])
            return "(" + "*".join([text] * int(exponent)) + ")"
        if exponent.is_Integer and -4 <= int(exponent) <= -1:
            return (
                f"(1/{self._print_Pow(base**-exponent)})"
                if exponent != -1
                else (f"(1/{self.parenthesize(base, sp.printing.precedence.PRECEDENCE['Mul'])})")
            )
        return super()._print_Pow(expr)


def statements(targets: dict[str, sp.Expr], real: str = "real") -> str:
    """Assignments to `targets` by way of common subexpressions."""
    printer = _Printer()
    shared, reduced = sp.cse(list(targets.values()), symbols=sp.numbered_symbols("x_"))
    lines = [f"    const {real} {symbol} = {printer.doprint(e)};" for symbol, e in shared]
    lines += [
        f"    {target} = {printer.doprint(e)};" for target, e in zip(targets, reduced, strict=True)
    ]
    return "\n".join(lines)


def _unpacked(m: Model, expressions: list[sp.Expr], real: str) -> str:
    """q, v and the time as names, those that are used."""
    used = set().union(*(e.free_symbols for e in expressions))
    lines = [f"    const {real} {x} = q[{i}];" for i, x in enumerate(m.q) if x in used]
    lines += [f"    const {real} {x} = v[{i}];" for i, x in enumerate(m.v) if x in used]
    return "\n".join(lines)


def parameters(m: Model, real: str = "double") -> str:
    """Not static, so that the compiler may not fold them: in use they change between runs."""
    values = ", ".join(v.hex() for v in m.values)
    return f"extern {real} bench_parameters[];\n{real} bench_parameters[] = {{{values}}};\n"


def _bound(m: Model, expressions: list[sp.Expr], real: str) -> str:
    used = set().union(*(e.free_symbols for e in expressions))
    return "\n".join(
        f"    const {real} {x} = bench_parameters[{i}];"
        for i, x in enumerate(m.parameters)
        if x in used
    )


def acceleration(m: Model, real: str = "double") -> str:
    """`acceleration(t, q, v, a)` in closed form."""
    return written_out(m, list(equations(m.name).acceleration), real)


def written_out(m: Model, found: list[sp.Expr], real: str) -> str:
    """The same of any expressions in q, v and the parameters of m."""
    targets = {f"a[{i}]": e for i, e in enumerate(found)}
    return f"""enum {{ N = {m.n} }};
{parameters(m, real)}
static int acceleration({real} t, const {real} *q, const {real} *v, {real} *a)
{{
    (void)t, (void)q, (void)v;
{_bound(m, found, real)}
{_unpacked(m, found, real)}
{statements(targets, real)}
    return 0;
}}
"""


def mass_and_force(m: Model, real: str = "double") -> str:
    """`mass_and_force(t, q, v, M, f)`, all of M written, row after row."""
    derived = equations(m.name)
    found = [*derived.mass, *derived.force]
    targets = {f"M[{i}]": e for i, e in enumerate(derived.mass)}
    targets |= {f"f[{i}]": e for i, e in enumerate(derived.force)}
    return f"""enum {{ N = {m.n} }};
{parameters(m, real)}
static void mass_and_force({real} t, const {real} *q, const {real} *v, {real} *M, {real} *f)
{{
    (void)t, (void)q, (void)v;
{_bound(m, found, real)}
{_unpacked(m, found, real)}
{statements(targets, real)}
}}
"""
