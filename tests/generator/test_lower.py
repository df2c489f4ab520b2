"""lower: what becomes a statement, what is hoisted, how expressions read, what is counted."""

import re
from collections import Counter
from dataclasses import replace
from fractions import Fraction

import pytest
from building import links
from c_harness import MODELS, lowered, read_model, read_text, without_facts

from pkgen.back.c.ctext import comment, fold, fold_call, string
from pkgen.back.c.expressions import (
    Code,
    added,
    atom,
    called,
    code,
    constant,
    inverted,
    literal,
    multiplied,
    negated,
    variable,
)
from pkgen.back.c.lower import lower
from pkgen.back.c.names import LOCAL_RESERVED, Names, local_wish
from pkgen.back.c.program import operations_text
from pkgen.back.targets import CHECK, LOCAL, RETURN, STORE
from pkgen.front.check.check import check_text
from pkgen.graph.graph import ZERO, Graph
from pkgen.middle.derive.derive import derive
from pkgen.source import Source

TOY = "model toy\nparam m = 1\nparam k = 2 in (0, inf)\ncoord x\nkinetic m*x'^2\npotential {}\n"


@pytest.mark.parametrize(
    ("potential", "expected", "hoisted"),
    [
        ("x - k", "return x - p->k", []),
        ("k - x", "return p->k - x", []),
        ("k/x", "return p->k / x", []),
        ("x^(-2)", "inv_x = 1 / x; return inv_x * inv_x", []),
        ("x^(1/2)", "return PK_F(sqrt)(x)", []),
        ("x^(3/2)", "sqrt_x = PK_F(sqrt)(x); return sqrt_x * sqrt_x * sqrt_x", []),
        ("x^(2/3)", "return PK_F(pow)(x, PK_C(2.0) / PK_C(3.0))", []),
        ("x^5", "x_sq = x * x; return x * x_sq * x_sq", []),
        ("m*(x*k)", "return p->m_k * x", ["p->m * p->k"]),
        ("x/m", "return p->inv_m * x", ["1 / p->m"]),
        ("exp(x)/(x^2 + k)", "return PK_F(exp)(x) / (x * x + p->k)", []),
        ("1/3*x", "return (PK_C(1.0) / PK_C(3.0)) * x", []),
        ("-9.81*x", "return -PK_C(9.81) * x", []),
    ],
)
def test_expression_reads_as_a_person_writes_it(potential, expected, hoisted):
    program = lowered(TOY.format(potential), "potential")
    kernel = program.kernel("potential")
    texts = [str(s) for b in kernel.blocks for s in b.statements if s.kind != "load"]
    text = "; ".join(t.removeprefix("const pk_real ").removesuffix(";") for t in texts)
    stored = [s for b in program.prepare.blocks for s in b.statements if s.kind == STORE]
    assert (text, [s.text for s in stored if s.target in text]) == (expected, hoisted)


def test_double_pendulum_is_small():
    _, program = read_model(next(p for p in MODELS if p.stem == "double_pendulum"))
    counts = {k.name: sum(k.operations.values()) for k in program.kernels}
    assert 10 < counts["acceleration"] <= 36
    assert 4 < counts["mass"] <= 10
    assert 10 < counts["force"] <= 22
    acceleration = program.kernel("acceleration")
    assert acceleration is not None
    assert acceleration.operations["/"] == 1
    assert acceleration.operations["sin"] == acceleration.operations["cos"] == 2


def test_nothing_is_computed_twice_in_a_kernel():
    for path in MODELS:
        _, program = read_model(path)
        for kernel in program.kernels:
            texts = [s.text for b in kernel.blocks for s in b.statements if s.kind == LOCAL]
            assert len(texts) == len(set(texts)), (path.stem, kernel.name)


def test_every_local_is_used_and_known():
    for path in MODELS:
        _, program = read_model(path)
        for kernel in (*program.kernels, program.prepare, program.start):
            statements = [s for b in kernel.blocks for s in b.statements]
            known: set[str] = set()
            used: set[str] = set()
            for s in statements:
                words = set(re.findall(r"(?<![\w>])[a-zA-Z_]\w*", s.text))
                used |= words
                assert not ({w for w in words if re.fullmatch(r"t\d+", w)} - known)
                for name in s.defines:
                    assert name not in known
                    known.add(name)
            assert known <= used, (path.stem, kernel.name, known - used)


def test_checks_come_before_everything_that_is_written():
    for path in MODELS:
        _, program = read_model(path)
        kernel = program.kernel("acceleration")
        assert kernel is not None
        kinds = [s.kind for b in kernel.blocks for s in b.statements]
        assert STORE in kinds
        if CHECK in kinds:
            assert max(i for i, k in enumerate(kinds) if k == CHECK) < kinds.index(STORE)


def test_kernels_can_be_chosen_and_bring_what_they_call():
    names = [k.name for k in lowered(links(3), "acceleration", unroll=False).kernels]
    assert names == ["acceleration", "mass", "force"]
    assert [k.name for k in lowered(links(3), "energy").kernels] == ["energy"]


def test_dump_is_text():
    _, program = read_model(next(p for p in MODELS if p.stem == "bead_on_hoop"))
    assert "kernel acceleration: " in str(program)
    assert "default R = 1" in str(program)


def test_a_deep_chain_needs_no_recursion():
    e = derive(check_text(Source("deep.lag", TOY.format("sin(x)")))[0])
    node = e.potential
    for _ in range(10_000):
        node = e.graph.call("sin", node)
    e = replace(e, potential=node, acceleration=None, pivots=None)
    (kernel,) = lower(e, without_facts(1), frozenset({"potential"})).kernels
    assert kernel.operations["sin"] == 10_001
    assert max(len(s.text) for b in kernel.blocks for s in b.statements) < 300
    assert len(kernel.blocks) > 1  # cut up for the compiler's sake


def test_a_long_sum_is_cut_into_lines_and_blocks_hand_values_on():
    (kernel,) = lowered(TOY.format("sum(sin(i*x), i = 2..2999)"), "potential").kernels
    assert kernel.operations["sin"] == 2998
    assert max(len(s.text) for b in kernel.blocks for s in b.statements) < 300


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (Fraction(3), "3"),
        (Fraction(2**24 + 1), "PK_C(16777217.0)"),
        (Fraction(1, 2), "PK_C(0.5)"),
        (Fraction(981, 100), "PK_C(9.81)"),
        (Fraction(2, 3), "(PK_C(2.0) / PK_C(3.0))"),
        (Fraction(667430, 10**16), "PK_C(6.6743e-11)"),
        (Fraction(5972 * 10**21), "PK_C(5.972e24)"),
        (Fraction(1, 1000), "PK_C(0.001)"),
    ],
)
def test_literals(value, text):
    assert literal(value) == text


def test_a_literal_that_is_no_short_fraction_has_sixty_digits():
    text = literal(Fraction(10**30 + 7, 3 * 10**29))
    assert re.fullmatch(r"PK_C\(3\.3{27}\d+\)", text)
    assert len(re.sub(r"\D", "", text)) == 60


def test_an_expression_knows_what_it_reads_and_computes():
    a, b, c = (atom(variable(name)) for name in ("a", "b", "p->c"))
    third = atom(Code("(PK_C(1.0) / PK_C(3.0))"))
    step = called("m_step", [added(c, constant("-2"))], "step")
    sine = called("PK_F(sin)", [b], "sin")
    found = code(added(negated(multiplied(a, sine)), multiplied(step, inverted(third))))
    assert found == "m_step(p->c - 2) / (PK_C(1.0) / PK_C(3.0)) - a * PK_F(sin)(b)"
    assert found.reads == ("p->c", "a", "b") and found.names == {"p", "a", "b"}
    counted = Counter(found.operations)
    assert counted == {"*": 1, "sin": 1, "-": 2, "step": 1, "/": 1}
    assert operations_text(counted) == "6 operations: 2 -, 1 *, 1 /, 1 sin, 1 step"
    minus = code(negated(a))
    assert minus == "-a" and minus.operations == ("neg",)
    assert code(third) == "PK_C(1.0) / PK_C(3.0)" and not code(third).operations
    assert code(inverted(multiplied(a, inverted(b)))) == "1 / (a / b)"


def test_names():
    names = Names(LOCAL_RESERVED)
    taken = [names.take(x) for x in ["I", "I_", "y1", "q", "_X", "pk_real", "x", "x"]]
    assert taken == ["I_", "I__", "y1_", "q_", "x_X", "xpk_real", "x", "x_"]
    assert names.number("t") == "t1"
    assert local_wish("theta1'") == "theta1_dot"
    assert local_wish("q[3]") == "q3"
    assert local_wish("x1[3]'") == "x1_3_dot"


def test_comments_and_strings_cannot_break_out():
    assert comment("a */ b /* c ??/ d\\") == "a * / b / * c ? ?/ d/"
    assert "*/" not in comment("**//*/**/") and "/*" not in comment("**//*/**/")
    assert "\u202e" not in comment("a\u202eb")
    assert string('say "hi"\\ ??/ \x07') == '"say \\"hi\\"\\\\ ?\\?/ ?"'
    assert string("θ1") == '"\\316\\2701"'
    assert len(string("x" * 9000)) < 600


def test_lines_fold_at_the_outermost_operator():
    line = "const pk_real f = " + " + ".join(f"(a{i} * b{i} - c{i} * d{i})" for i in range(9)) + ";"
    folded = fold(line, 4)
    assert all(len(x) <= 100 for x in folded.splitlines())
    assert all(x.startswith("        + ") for x in folded.splitlines()[1:])
    assert " ".join(folded.split()) == line


def test_what_cannot_be_short_is_folded_where_it_can():
    name = "n" * 120
    assert fold_call(f"void {name}(int a, int b)") == f"void {name}(int a,\n    int b)"


def test_a_return_is_last():
    _, program = read_text("model m\ncoord x\nkinetic x'^2/2\npotential cos(x)\n")
    for name in ("energy", "kinetic", "potential", "lagrangian"):
        kernel = program.kernel(name)
        assert kernel is not None
        assert kernel.blocks[-1].statements[-1].kind == RETURN


def test_the_graph_is_not_touched():
    equations = derive(links(2))
    before = len(equations.graph)
    lower(equations, without_facts(2))
    assert len(equations.graph) == before
    assert isinstance(equations.graph, Graph) and equations.graph.number(0) == ZERO
