"""lower: sine and cosine of one angle are one statement, two angles share a call."""

from c_harness import MODELS, lowered, read_model, read_text, without_facts

from pkgen.back.c.lower import lower
from pkgen.back.targets import LOCAL, TRIG


def trig_statements(kernel) -> list[tuple[list[str], list[str]]]:
    """Of each call of the inline pair, the angles and the names of what it gives."""
    found = [s for b in kernel.blocks for s in b.statements if s.kind == TRIG]
    return [(s.text.split("; "), s.target.split()) for s in found]


def test_sine_and_cosine_of_one_angle_are_one_call_and_have_names():
    _, program = read_model(next(p for p in MODELS if p.stem == "double_pendulum"))
    for kernel in program.kernels:
        calls = trig_statements(kernel)
        angles = [angle for found, _ in calls for angle in found]
        assert sorted(angles) == ["theta1", "theta2"], kernel.name
        for found, names in calls:
            expected = [f"{function}_{x}" for x in found for function in ("sin", "cos")]
            assert all(n in (x, "NULL") for n, x in zip(names, expected, strict=True))
            assert set(names) != {"NULL"}


def test_two_angles_known_from_the_start_share_a_call_others_wait():
    text = "model toy\ncoord x, y, z\nkinetic x'^2 + y'^2 + z'^2\n"
    text += "potential sin(cos(x)) + sin(y) + sin(z) + cos(z)\n"
    (kernel,) = lowered(text, "potential").kernels
    assert trig_statements(kernel) == [
        (["x", "y"], ["NULL", "cos_x", "sin_y", "NULL"]),
        (["cos_x", "z"], ["sin_cos_x", "NULL", "sin_z", "cos_z"]),
    ]
    assert (kernel.operations["sin"], kernel.operations["cos"]) == (3, 2)


def test_what_is_not_needed_is_not_counted():
    _, program = read_text("model one\ncoord x\nkinetic x'^2/2\npotential cos(x)\n")
    force, potential = program.kernel("force"), program.kernel("potential")
    assert force is not None and potential is not None
    assert "cos" not in force.operations and force.operations["sin"] == 1
    assert "sin" not in potential.operations and potential.operations["cos"] == 1


def test_with_libm_sine_and_cosine_are_its_functions_next_to_each_other():
    equations, _ = read_model(next(p for p in MODELS if p.stem == "double_pendulum"))
    program = lower(equations, without_facts(2), libm=True)
    assert not program.has_sincos
    for kernel in program.kernels:
        assert not trig_statements(kernel)
        names = [s.target for b in kernel.blocks for s in b.statements if s.kind == LOCAL]
        for i, name in enumerate(names):
            if name.startswith("sin_") and "cos_" + name[4:] in names:
                assert names[i + 1] == "cos_" + name[4:]
