"""Random chains of links whose places are defined from the former link's, one value at a time."""

from __future__ import annotations

import random


def links(dice: random.Random, states: bool = False) -> str:
    """Absolute or relative angles, point masses or rods, a beginning that rests, is driven or is
    a cart's, springs, ends of each kind, forces, drag, states and pair sums beside."""

    def of(*choices: str) -> str:
        return dice.choice(choices)

    relative, first = dice.random() < 0.5, of("0", "0", "1")
    vector, rods = dice.random() < 0.3, dice.random() < 0.3
    pivot = of("0", "0.3*sin(2*t)", "X", "X + push", "exp(-t)*X^2")
    text = "model links\nsize N = 5\nparam g = 9.81\nparam k = 1.3\n"
    text += "param m[i = 1..N] = 1 + 0.3*cos(2*i) in (0, inf)\n"
    text += "param l[i = 1..N] = 1 + 0.2*sin(i) in (0, inf)\n"
    text += "coord q[1..N]\n"
    if "X" in pivot or dice.random() < 0.3:
        text += f"coord X\nkinetic {of('2', '(2 + cos(X))')}*X'^2\npotential X^2/2\n"
    beside = "X" if "coord X" in text else "0"
    text += "input push\n" if "push" in pivot else ""
    springs = dice.random() < 0.5
    end = of(
        "fixed q[0] = 0.2\nfree q[N+1]\n",
        "fixed q[0] = 0.1*sin(t), q[N+1] = 0\n",
        "free q\n",
        "periodic q\n",
    )
    text += end if springs else ""
    lo = "1" if first == "0" else "2"
    turned = "q[i]"
    if relative:
        text += f"let a[{first}] = {of('0', '0.2*t')}{' + q[1]' if first == '1' else ''}\n"
        text += f"let a[i = {lo}..N] = a[i-1] + {of('q[i]', 'k*q[i]', 'sin(q[i])')}\n"
        turned = "a[i]"
    x, y = of("l[i]", "1.1") + f"*sin({turned})", f"l[i]*cos({turned})"
    own = f" + l[1]*sin({turned.replace('[i]', '[1]')})" if first == "1" else ""
    if vector:
        text += f"let r[{first}] = [{pivot}{own}, 0, {of('0', 'k')}]\n"
        text += f"let r[i = {lo}..N] = r[i-1] + [{x}, -{y}, {of('0', 'q[i]^2/3')}]\n"
        x_of, y_of = "r[{}].x", "r[{}].y"
    else:
        text += f"let x[{first}] = {pivot}{own}\nlet y[{first}] = {of('0', '0.2*cos(t)')}\n"
        text += f"let x[i = {lo}..N] = x[i-1] + {x}\n"
        text += f"let y[i = {lo}..N] = {of('y[i-1]', '0.9*y[i-1]')} - {y}\n"
        x_of, y_of = "x[{}]", "y[{}]"

    def place(form: str, at: str) -> str:
        return form.format(at)

    def middle(form: str) -> str:
        return f"(({place(form, 'i-1')} + {place(form, 'i')})/2)"

    begin = 1 if first == "0" else 2
    mx, my = (middle(x_of), middle(y_of)) if rods else (place(x_of, "i"), place(y_of, "i"))
    text += f"kinetic sum(m[i]/2*(({mx})'^2 + ({my})'^2), i = {begin}..N)\n"
    if rods or begin == 2 or dice.random() < 0.3:
        text += "kinetic sum(m[i]*l[i]^2/24*q[i]'^2, i = 1..N)\n"
    if dice.random() < 0.25:
        text += "kinetic sum((q[i]' - q[i-1]')^2/9, i = 2..N)\n" if not springs else ""
    if dice.random() < 0.3:
        text += f"kinetic sum(q[i]'*({beside})'/7, i = 1..N)\n" if beside == "X" else ""
    text += f"potential sum(m[i]*g*{my}, i = {begin}..N)\n"
    if springs:
        text += "potential sum(k/2*(q[i+1] - q[i])^2, i = 1..N)\n"
        text += "potential sum(cos(q[i] - q[i-1]), i = 1..N)\n"
    if dice.random() < 0.3:
        text += f"potential k*({place(x_of, 'N')} - 1)^2\n"
    if dice.random() < 0.3:
        text += f"dissipation sum(0.1*({place(x_of, 'i')})'^2 + q[i]'^2/7, i = 1..N)\n"
    if dice.random() < 0.3:
        text += f"force q[i = 1..N] = -0.1*q[i]'*({place(y_of, 'i')})' + {beside}\n"
    if dice.random() < 0.2:
        text += (
            f"potential sum(1/(1 + ({place(x_of, 'i')} - {place(x_of, 'j')})^2), "
            "i = 1..N-1, j = i+1..N)\n"
        )
    if states:
        text += "state s[1..N]\nrate s[i = 1..N] = q[i] - s[i]\n"
        text += "potential sum(s[i]*q[i], i = 1..N)\n"
    text += f"observe tip = {place(x_of, 'N')} + ({place(y_of, 'N')})'\n"
    text += f"observe spread = sum(m[i]*{place(x_of, 'i')}^2, i = 1..N)*energy\n"
    return text + "start q[i = 1..N] = 0.3*i, q[1]' = 1\n"
