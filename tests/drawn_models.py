"""Random models with inputs, states and a rotation, and differences of functions of them."""

from __future__ import annotations

import random

import numpy


def drawn(chance: random.Random) -> tuple[str, list[str], list[str]]:
    """A random model: its text, parameters, inputs."""
    n, rotation = chance.randint(1, 3), chance.random() < 0.3
    q, p = [f"q{k}" for k in range(n)], [f"k{k}" for k in range(3)]
    u = ["u0", "u1"][: chance.randint(1, 2)]

    def term() -> str:
        a, b = chance.choice(q), chance.choice(q)
        of = chance.choice(
            ["sin({a})*{p}", "{p}^2*{a}*{b}", "exp({p}*{a}/4)", "cos({a} - {p}*{b})"]
        )
        return f"{chance.uniform(-1, 1):.3f}*" + of.format(a=a, b=b, p=chance.choice(p))

    lines = ["model drawn", *(f"param {x} = {chance.uniform(0.5, 1.5):.3f}" for x in p)]
    lines += [f"coord {', '.join(q)}", f"input {', '.join(u)}"]
    kinetic = [f"(1.5 + {chance.choice(p)}*cos({chance.choice(q)})/4)*{x}'^2" for x in q]
    if n > 1:
        kinetic.append(f"0.3*sin({q[0]})*{q[0]}'*{q[1]}'*{chance.choice(p)}")
    if rotation:
        lines += [
            "rotation R",
            "let w = omega(R)",
            "start R = rot([1, 0, 0], 0.9)*rot([0, 1, 0], -0.7)",
        ]
        lines += ["start omega(R) = [0.3, -0.2, 0.4]"]
        kinetic.append(f"{p[0]}*w.x^2 + w.y^2 + 0.7*w.z^2 + 0.1*w.x*{q[0]}'")
        lines.append(f"potential {p[1]}*dot(R*[0, 0, 1], [0, 1, {q[0]}])")
    state = chance.random() < 0.5
    lines += [f"kinetic {' + '.join(kinetic)}", f"potential {term()} + {term()} + {q[0]}^2"]
    lines.append(f"force {q[0]} = {u[0]}*{p[0]} + {u[-1]}*{q[-1]} - {p[1]}*{q[0]}'")
    if state:
        lines += ["state s", f"rate s = {q[0]}' - {p[2]}*s + {u[-1]}*s", "start s = 0.4"]
    lines.append(f"observe a = {q[0]}*{u[0]} + {p[0]}*{q[-1]}'^2" + (" + s" if state else ""))
    lines.append(f"observe b = {q[0]}''")
    lines.append("start " + ", ".join(f"{x} = {chance.uniform(-1, 1):.3f}" for x in q))
    lines.append("start " + ", ".join(f"{x}' = {chance.uniform(-1, 1):.3f}" for x in q))
    return "\n".join(lines) + "\n", p, u


def slope(f, x: numpy.ndarray, by: numpy.ndarray, h: float = 2e-3) -> numpy.ndarray:
    """The derivative of f at x along `by`, by differences of order 6."""
    d = [f(x + k * h * by) - f(x - k * h * by) for k in (1, 2, 3)]
    return (45 * d[0] - 9 * d[1] + d[2]) / (60 * h)
