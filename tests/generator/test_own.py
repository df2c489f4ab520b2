"""Methods of the author's own: the order conditions, tableau files, what is wrong in them."""

import itertools
import math
import random
import re
from fractions import Fraction

import pytest

from conftest import ROOT
from pkgen.front.check.check import check_text
from pkgen.front.read import from_text
from pkgen.own import words
from pkgen.own.made import c_number, facts, fit, of_text, of_weights
from pkgen.own.tableau import NotANumber, number, read_tableau
from pkgen.own.trees import Conditions, scaled, trees
from pkgen.source import ModelError

TABLES = ROOT / "runtime/include/pk/step"
RK4 = "A\n0\n1/2\n0 1/2\n0 0 1\nb 1/6 1/3 1/3 1/6\n"
BS23 = "A\n0\n1/2\n0 3/4\n2/9 1/3 4/9\nb 2/9 1/3 4/9 0\nbhat 7/24 1/4 1/3 1/8\n"
TRIPLE = "1.3512071919596576340,-1.7024143839193152681,1.3512071919596576340"
YOSHIDA6 = (0.78451361047755726382, 0.23557321335935813368, -1.17767998417887100695)


def tableau(text: str):
    return read_tableau(from_text("m.tab", text))


def wrong(text: str) -> str:
    with pytest.raises(ModelError) as failed:
        of_text("mine", from_text("m.tab", text))
    return failed.value.text()


def test_rooted_trees() -> None:
    """Their numbers (Cayley 1857, OEIS A000081), and two sums over all trees of an order."""
    assert [len(trees(n)) for n in range(1, 11)] == [1, 1, 2, 4, 9, 20, 48, 115, 286, 719]
    for n in range(1, 9):
        # Butcher: sum of n!/(sigma gamma) is (n-1)!, and of n!/sigma is n^(n-1).
        of = trees(n)
        top = math.factorial(n)
        assert sum(Fraction(top, t.sigma * t.gamma) for t in of) == math.factorial(n - 1)
        assert sum(Fraction(top, t.sigma) for t in of) == n ** (n - 1)


def dop853() -> str:
    text = (TABLES / "dop853.h").read_text()
    tables = (re.search(rf"dop853_{x}\[\] = {{(.*?)}};", text, re.S)[1] for x in "ab")
    a, b = (re.findall(r"[\d.eE+-]+", re.sub(r"PK_C", "", table)) for table in tables)
    rows = [" ".join(a[i * (i - 1) // 2 : i * (i + 1) // 2]) for i in range(1, 12)]
    return "\n".join(["A", "0", *rows, "b " + " ".join(b)])


@pytest.mark.parametrize(
    ("text", "order", "constant"),
    [
        ("A\n0\nb 1", 1, 0.5),
        ("A\n0\n1/2\nb 0 1", 2, math.hypot(1 / 24, 1 / 6)),
        (RK4, 4, 0.01450),  # Butcher, and Dormand and Prince
        (BS23, 3, 0.0418),
        (dop853(), 8, None),
        ("A\n1/2\nb 1", 2, None),
        # Gauss, two stages, to 16 digits.
        (
            "A\n0.25 -0.03867513459481288\n0.5386751345948129 0.25\nb 1/2 1/2",
            4,
            None,
        ),
    ],
)
def test_orders_known(text: str, order: int, constant: float | None) -> None:
    found = facts(tableau(text))
    assert found["order"] == order
    if constant is not None:
        assert found["error constant"] == pytest.approx(constant, rel=2e-3)


def test_a_coefficient_off_by_a_billionth_is_seen() -> None:
    assert facts(tableau(RK4.replace("0 0 1", "0 0 1.000000001")))["order"] == 1


def test_geometry() -> None:
    gauss = "A\n0.25 -0.03867513459481288\n0.5386751345948129 0.25\nb 1/2 1/2"
    found = facts(tableau(gauss))
    assert found["symplectic"] and found["symmetric"] and found["class"] == "fully implicit"
    trapezoidal = facts(tableau("A\n0\n1/2 1/2\nb 1/2 1/2"))
    assert trapezoidal["symmetric"] and not trapezoidal["symplectic"]
    assert not facts(tableau(RK4))["symmetric"]


def test_pairs() -> None:
    own = of_text("mine", from_text("m.tab", BS23))
    assert own.family == "EMBEDDED" and (own.order, own.stages) == (3, 3)  # the last is the next
    assert dict(own.facts)["embedded order"] == 2
    assert ".error_order = 3" in own.table
    slow = of_text("mine", from_text("m.tab", "A\n0\n1\nb 1/2 1/2\nbhat 1 0"))
    assert slow.stages == 2 and ".error_order = 2" in slow.table
    assert "pk_mine_e[] = {PK_C(-1.0) / PK_C(2.0), PK_C(1.0) / PK_C(2.0), PK_C(0.0)}" in slow.table


@pytest.mark.parametrize(
    ("weights", "order", "mirrored"),
    [
        ("1", 2, True),
        ("1/2,1/2", 2, True),
        ("1/3,2/3", 2, False),
        (TRIPLE, 4, True),
        (
            ",".join(f"{x:.17g}" for x in (*YOSHIDA6, 1 - 2 * sum(YOSHIDA6), *YOSHIDA6[::-1])),
            6,
            True,
        ),
    ],
)
def test_compositions(weights: str, order: int, mirrored: bool) -> None:
    own = of_weights("mine", weights)
    assert own.order == order and ("symmetric" in own.traits) == mirrored


def test_a_weight_off_by_a_billionth_is_seen() -> None:
    assert of_weights("mine", "1.351207193,-1.702414386,1.351207193").order == 2


def test_words_of_a_splitting_of_order_one() -> None:
    assert words.order([Fraction(1), Fraction(0)], [Fraction(1)])[0] == 1


def test_order_three_of_cubes_that_cancel() -> None:
    """The weights of a composition with sum 1 and a sum of cubes 0, not symmetric."""
    a, b = 0.5, 0.7
    low, high = -5.0, 5.0  # of c, with d = 1 - a - b - c
    f = lambda c: a**3 + b**3 + c**3 + (1 - a - b - c) ** 3  # noqa: E731
    xs = [low + (high - low) * k / 2000 for k in range(2001)]
    at = next(x for x, y in itertools.pairwise(xs) if f(x) * f(y) < 0)
    left, right = at, at + (high - low) / 2000
    for _ in range(80):
        middle = (left + right) / 2
        left, right = (middle, right) if f(left) * f(middle) > 0 else (left, middle)
    own = of_weights("mine", f"{a},{b},{left!r},{1 - a - b - left!r}")
    assert own.order == 3 and "symmetric" not in own.traits


def test_a_number_is_rounded_once() -> None:
    for text in ("0.1", "1/3", "-2.5e-1", "1.3512071919596576340476878089715", "1e-20"):
        code = c_number(number(text)).replace("PK_C", "")
        assert eval(code) == float(number(text))


def test_numbers_that_are_none() -> None:
    bad = ("nan", "inf", "1//2", "1/0", "1e99", "1e-60", "0x10", "1_0", "pi", "2**9", "1,", "١", "")
    for text in (*bad, "9" * 61, "1" * 10**6):
        with pytest.raises(NotANumber):
            number(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "m.tab:1:1: error: there is no A"),
        ("1 2", "m.tab:1:1: error: '1' stands before any section"),
        ("A\n0\nb 1/2 1/2", "m.tab:3:3: error: A has 1 row, b has 2 weights"),
        ("A\n0\n1\nb 1/2 1/3", "m.tab:4:3: error: the weights 'b' sum to 0.8333"),
        ("A\n0\n1\nb 1/2 1/2\nbhat 1", "m.tab:5:6: error: 'bhat' has 1 weights, b has 2"),
        ("A\n0\n1\nb 1/2 1/2\nbhat 1/2 1/2", "b and bhat are the same"),
        ("A\n0\n1 2 3\nb 1/2 1/2", "m.tab:3:1: error: a row of 3 numbers in a method of 2"),
        ("A\n0\n__import__('os')\nb 1 0", "m.tab:3:1: error: '__import__('os')' is no number"),
        ("A\n" + "0\n" * 65 + "b 1", "more than 64 stages"),
        ("A\n1/2\nb 1", "m.tab:1:1: error: the method is diagonally implicit"),
        ("A\n1 1\n1 1\nb 1/2 1/2", "the method is fully implicit"),
        ("A\n" + "0\n" * 17 + "b 1" + " 0" * 16, "17 stages"),
        ("#" * 300_000, "a tableau of 300,000 characters"),
    ],
)
def test_wrong_files(text: str, said: str) -> None:
    found = wrong(text)
    assert said in found and "help:" in found and "^" in found


def test_any_text_is_a_tableau_or_refused() -> None:
    random.seed(24)
    words_of = "A b bhat 0 1 1/2 -1 1e9 nan / # : , é \x00 ( ) ' \\ 1/6 0.5"
    some = words_of.split() + ["\n"] * 6
    made = 0
    for _ in range(3000):
        text = " ".join(random.choices(some, k=random.randrange(1, 25)))
        try:
            of_text("mine", from_text("m.tab", text))
            made += 1
        except ModelError as failed:
            assert failed.text()
    assert made < 3000


def test_names() -> None:
    assert fit("rk4") == "own_rk4" and fit("My method-3") == "my_method_3" and fit("3/8") == "m_3_8"


def test_weights_that_are_wrong() -> None:
    for text, said in (("1,1", "sum to 2"), ("1,,0", "no number"), ("1," * 80 + "1", "81 weights")):
        with pytest.raises(ModelError) as failed:
            of_weights("mine", text)
        assert said in failed.value.text()


MODEL = "model m\ncoord x\nlagrangian x'^2/2 - x^2/2\n{}\nscene s\n until 1\n{}\nend\n"


def test_the_statement(tmp_path) -> None:
    (tmp_path / "mine.tab").write_text(RK4)
    (tmp_path / "pair.tab").write_text(BS23)
    path = str(tmp_path / "m.lag")

    def checked(top: str, clause: str):
        return check_text(from_text(path, MODEL.format(top, clause)))[0]

    model = checked("method mine tableau mine.tab", " method mine step 0.1")
    assert [m.name for m in model.methods] == ["mine"] and model.methods[0].order == 4
    model = checked("", " method pair tableau pair.tab rtol 1e-6")
    assert model.methods[0].family == "EMBEDDED" and model.scenes[0].method == "pair"
    # A file that has changed is read anew.
    (tmp_path / "mine.tab").write_text("A\n0\nb 1\n")
    model = checked("method mine tableau mine.tab", " method mine step 0.1")
    assert model.methods[0].order == 1
    for top, clause, said in (
        ("method mine", "", "does not say what it is"),
        ("method rk4 tableau mine.tab", "", "'rk4' is one of pkgen's methods"),
        ("method mine tableau none.tab", "", "there is no such file"),
        ("method mine tableau mine.tab step 1", "", "'step' is of a scene"),
        ("method mine tableau", "", "'tableau' names no file"),
        ("method x tableau mine.tab\nmethod x tableau pair.tab", "", "another method 'x' already"),
        ("", " method mine tableau mine.tab", "mine has a fixed step"),
        ("", " method mine tableau mine.tab step 0.1 rtol 1e-3", "'rtol' is for adaptive methods"),
        ("", " method min step 0.1", "there is no method 'min'"),
    ):
        with pytest.raises(ModelError) as failed:
            checked(top, clause)
        assert said in failed.value.text()


def test_scaled_integers() -> None:
    assert abs(scaled(Fraction(1, 3)) * 3 - (1 << 256)) <= 3
    assert Conditions([[Fraction(0)]]).order([Fraction(1)]) == (1, 0.5)
