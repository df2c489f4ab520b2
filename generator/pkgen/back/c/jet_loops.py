"""The kernel `jet` of a large model: a loop over the orders k, with an array for each series.

Straight-line code is faster, but its length grows as the square of the order, and compilers are
superlinear in it.
"""

from __future__ import annotations

import re

from .ctext import fold

_SUMS = """\
/* Sums of a_j b_(k-j): of 0 < j < k, of j >= 1, of all j, and of these with j >= 1 over k. */
static pk_real NAME_jet_middle(int k, const pk_real *a, const pk_real *b)
{
    pk_real even = 0, odd = 0;
    int j = 1;

    for (; j + 1 < k; j += 2) {
        even += a[j] * b[k - j];
        odd += a[j + 1] * b[k - j - 1];
    }
    return even + odd + (j < k ? a[j] * b[k - j] : 0);
}

static pk_real NAME_jet_tail(int k, const pk_real *a, const pk_real *b)
{
    return NAME_jet_middle(k, a, b) + a[k] * b[0];
}

static pk_real NAME_jet_times(int k, const pk_real *a, const pk_real *b)
{
    return a[0] * b[k] + NAME_jet_tail(k, a, b);
}

static pk_real NAME_jet_part(int k, const pk_real *a, const pk_real *b)
{
    return NAME_jet_tail(k, a, b) / (pk_real)k;
}

"""
_HELPERS = ("middle", "tail", "times", "part")


def looped(head: str, name: str, first: list[str], start: list[str], later: list[str]) -> str:
    """Returns the C function NAME_jet from the lines of jets.jet(): of coefficients 0, of step 0,
    and of the steps behind it."""
    lines = [*first, *start, *later]
    found = (re.match(r"const pk_real (\w+?)_(?:0|##pk_k1?) = ", line) for line in lines)
    series = list(dict.fromkeys(x[1] for x in found if x))
    of_series = re.compile(rf"\b({'|'.join(series)})_(0\b|##pk_k1|##pk_k)")
    places = {"0": "0", "##pk_k": "k", "##pk_k1": "k + 1"}

    def indexed(line: str) -> str:
        line = of_series.sub(lambda m: f"{m[1]}[{places[m[2]]}]", line)
        line = re.sub(r"PK_JET_SQUARE\(pk_k, (\w+)\)", rf"{name}_jet_times(k, \1, \1)", line)
        line = re.sub(
            r"PK_JET_HALF\(pk_k, (\w+)\)", rf"PK_C(0.5) * {name}_jet_middle(k, \1, \1)", line
        )
        line = re.sub(
            r"PK_JET_(MIDDLE|TAIL|TIMES|PART)\(pk_k", lambda m: f"{name}_jet_{m[1].lower()}(k", line
        )
        line = line.replace("PK_JET_OVER(pk_k1)", "over[k + 1]").replace(
            "PK_JET_OVER(pk_k)", "over[k]"
        )
        line = line.replace("pk_k1", "(k + 1)").replace("pk_k", "k")
        return re.sub(r"^const pk_real (\w+\[)", r"\1", re.sub(r" ?\(void\)\w+\[[k0]\];", "", line))

    def written(lines: list[str], depth: int) -> str:
        kept = (indexed(line) for line in lines if "if (order ==" not in line)
        return "".join(f"{fold(line, depth)}\n" for line in kept if line)

    body = written(later, 8)
    used = {"middle", *(x for x in _HELPERS if f"{name}_jet_{x}(" in body)}
    used |= {"tail"} if used > {"middle"} else set()
    helpers = re.split(r"(?=^static )", _SUMS.replace("NAME", name), flags=re.MULTILINE)
    helpers = helpers[:1] + [h for h, x in zip(helpers[1:], _HELPERS, strict=True) if x in used]
    arrays = fold(f"pk_real over[31], {', '.join(f'{x}[31]' for x in series)};", 4)
    return (
        f"{''.join(helpers)}{head}\n{{\n{arrays}\n    int k;\n\n"
        f"{written(first, 4)}    k = 0;\n    for (int j = 1; j <= 30; j++)\n"
        f"        over[j] = PK_C(1.0) / (pk_real)j;\n{written(start, 4)}"
        f"    for (k = 1; k < order; k++) {{\n{body}    }}\n    return 0;\n}}\n"
    )
