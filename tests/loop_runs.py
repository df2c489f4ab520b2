"""Random models whose runs as loops are compared with runs of their members written out: chains of
rods, rings, wheels that roll, bodies on joints, states of members.
Each start is on its constraints."""

import random

SIZE = 5  # of what is written out, rows that one coordinate couples densely too
INERTIA = (
    "",
    "",
    " + sum((2 + cos(x[i]))*(x[i]' - x[i-1]')^2/9, i = 1..N)",
    " + sum(z[i]'*X'/(7*N), i = 1..N) + sum(y[i]'*z[i]'/9, i = 1..N)",
)
SINGLES = (
    "constraint mean: sum(z[i], i = 1..N) = N*X\n",
    "constraint last[N]: z[N] + X*z[N]/5 = 0\n",
    "rolling slip: X'*(2 + sin(X)) = sum(z[i]'*(1 + z[i]^2), i = 1..N)\n",
)
OTHERS = (
    "rolling drift[i = 1..N]: z[i]' = 0.3*x[i]' + 0.2*X'*cos(z[i])\n",
    "constraint tie[i = 1..N]: w[i] + w[i]^3/9 = 0.2*z[i] + 0.1*z[i-1] + sin(t)^2/9\n",
    "constraint tie[i = 1..N]: w[i] = 0.3*z[i]*X + 0.1*z[i+1]\n",
)


def rope(dice: random.Random, size: int = SIZE) -> str:
    """Rods from an end that rests or is shaken, or in a ring, beside z, w and a scalar X."""
    shape = dice.choice(("hung", "hung", "shaken", "ring"))
    text = f"model rope\nsize N = {size}\nparam k = {dice.uniform(0.5, 1.5):.3f}\n"
    text += "coord x[1..N], y[1..N], z[1..N], w[1..N], X\n"
    zero = "0.1*sin(t)^2" if shape == "shaken" else "0"
    text += "periodic x, y\n" if shape == "ring" else f"fixed x[0] = {zero}, y[0] = 0\n"
    text += dice.choice(
        ("free z[0], z[N+1]\n", "fixed z[0] = 0, z[N+1] = 0.1*t^2\n", "periodic z\n")
    )
    inertia = dice.choice(INERTIA)
    text += "kinetic sum((1 + 0.2*i/N)*(x[i]'^2 + y[i]'^2)/2 + z[i]'^2/3 + w[i]'^2/4, i = 1..N)"
    text += f" + X'^2{inertia}\n"
    text += "potential sum(k*y[i] + (z[i] - z[i-1])^2 + w[i]^2 + z[i]^4/4, i = 1..N) + X^2\n"
    if dice.random() < 0.5:
        text += "potential sum(z[i]*sin(x[i]), i = 1..N)/5\n"
    if dice.random() < 0.5:
        text += "force x[i = 1..N] = -0.1*x[i]' + sin(t)/5\n"
    length = "2*sin(pi/N)" if shape == "ring" else "1"
    rod = f"constraint rod[i = 1..N]: (x[i] - x[i-1])^2 + (y[i] - y[i-1])^2 = ({length})^2\n"
    rows = [rod]
    free = ["z"]
    if dice.random() < 0.7:
        rows.append(dice.choice(OTHERS))
        free = [] if "drift" in rows[-1] else free
    if free and dice.random() < 0.6:
        rows.append(dice.choice(SINGLES))
    text += "".join(rows)
    if shape == "ring":
        text += "start x[i = 1..N] = cos(2*pi*i/N), y[i = 1..N] = sin(2*pi*i/N)\n"
        text += "start y[i = 1..N]' = 0.2\n"
    else:
        text += "start x[i = 1..N] = i*cos(0.4), y[i = 1..N] = sin(0.4)*(1 - cos(pi*i))/2\n"
    text += "observe pull = lambda_rod[1] + X\nobserve low = sum(y[i]*z[i], i = 1..N)\n"
    return (
        text
        + f"event near: {dice.choice(('y[N] + 0.1', 'x[2] - x[1] - 0.5', 'X - 0.02'))} either\n"
    )


def bodies(dice: random.Random, size: int = 5) -> str:
    """Bodies on joints: a chain of rotations whose ends meet, from a wall or free, or wheels."""
    text = f"model bodies\nsize N = {size}\nparam l = {dice.uniform(0.3, 0.7):.3f}\n"
    text += "coord x[1..N], y[1..N], z[1..N]\nrotation R[1..N]\n"
    body = dice.choice(("0.1, 0.3, 0.2", "0.2, 0.2, 0.05"))
    a, b, c = body.split(", ")
    text += (
        f"kinetic sum({a}*omega(R[i]).x^2 + {b}*omega(R[i]).y^2 + {c}*omega(R[i]).z^2, i = 1..N)\n"
    )
    text += "kinetic sum((x[i]'^2 + y[i]'^2 + z[i]'^2)/2, i = 1..N)\n"
    kind = dice.choice(("chain", "free", "wheels", "hinges"))
    if dice.random() < 0.5:
        text += "kinetic sum(0.1*(x[i]' + omega(R[i]).z)^2, i = 1..N)\n"
    if dice.random() < 0.4:  # momenta depend on attitudes
        text += "kinetic sum(0.05*(x[i]' + (R[i]*omega(R[i])).x)^2, i = 1..N)\n"
    text += "potential sum(z[i] + 0.3*(R[i]*[0, 0, 1]).x^2, i = 1..N)\n"
    if dice.random() < 0.5:
        text += "force R[i = 1..N] = -0.1*omega(R[i])\n"
    if kind == "wheels":
        text += "".join(
            f"rolling on_{d}[i = 1..N]: ([x[i]', y[i]', z[i]']"
            f" + cross(R[i]*omega(R[i]), [0, 0, -1])).{d} = 0\n"
            for d in "xy"
        )
        text += "constraint floor[i = 1..N]: z[i] = 1\nstart z[i = 1..N] = 1\n"
        text += "start omega(R[i = 1..N]) = [0.3, 0.1*i, 0.2]\n"
        text += "start x[i = 1..N]' = 0.1*i, y[i = 1..N]' = -0.3\n"
        text += "potential sum((x[i+1] - x[i])^2 + (y[i+1] - y[i])^2, i = 1..N-1)\n"
        return text + "observe first = lambda_on_x[1]\nobserve tip = (R[N]*[1, 0, 0]).y\n"
    text += "let p[i = 1..N] = [x[i], y[i], z[i]]\n"
    for d in "xyz":
        text += f"constraint joint_{d}[i = 1..N-1]: (p[i] + R[i]*[l, 0, 0]).{d}"
        text += f" = (p[i+1] - R[i+1]*[l, 0, 0]).{d}\n"
        if kind in ("chain", "hinges"):
            text += f"constraint wall_{d}: (p[1] - R[1]*[l, 0, 0]).{d} = 0\n"
    if kind == "hinges":  # about y, which stays level
        text += "constraint level[i = 1..N]: (R[i]*[0, 1, 0]).z = 0\n"
        text += "constraint ahead[i = 1..N]: (R[i]*[0, 1, 0]).x = 0\n"
    text += "start x[i = 1..N] = (2*i - 1)*l\n"
    if kind == "free":
        text += "start x[i = 1..N]' = 0.3, z[i = 1..N]' = 1\n"
    return text + "observe first = lambda_joint_x[1]\nobserve tip = (R[N]*[1, 0, 0]).z\n"


ENDS = (
    "fixed {f}[0] = {g}\nfixed {f}[N+1] = {g}\n",
    "free {f}[0]\nfixed {f}[N+1] = {g}\n",
    "free {f}[0]\nfree {f}[N+1]\n",
    "periodic {f}\n",
)
OF_TIME = ("0", "0.3", "sin(t)", "cos(2*t)/3")


def states(dice: random.Random, coordinates: bool = True, size: int = 23) -> str:
    """Displacements q, states u of each member, a state s of all: ends of every kind, inertia that
    couples neighbours and varies, states in V, D and forces, rates of whatever is near."""

    def number() -> str:
        return f"{dice.uniform(0.2, 1.5):.3f}"

    def of(*choices: str) -> str:
        return dice.choice(choices)

    text = (
        f"model chain\nsize N = {size}\nparam k = {number()}\nparam w[i = 1..N] = 1 + k/(i + 1)\n"
    )
    text += "coord q[1..N]\ncoord X\n" if coordinates else ""
    text += "state u[1..N]\nstate s\n"
    for family in ("q", "u") if coordinates else ("u",):
        text += dice.choice(ENDS).format(f=family, g=of(*OF_TIME))
    near = "q[i]" if coordinates else "u[i]"
    if coordinates:
        banded = of(
            "", "", " + sum((2 + cos(q[i]))*(q[i+1]' - q[i]')^2/9, i = 1..N-1)", " + q[2]'*X'/3"
        )
        text += f"kinetic sum(w[i]*q[i]'^2/2, i = 1..N) + X'^2{banded}\n"
        stiff = of("1", "k", "(1 + u[i]^2/3)", "(1 + s^2/5)")
        text += f"potential sum({stiff}*(q[i] - q[i-1])^2/2, i = 1..N) + sum(q[i]^4/4, i = 1..N)"
        text += of("", " + (X - q[3])^2/2", " + X^2*u[2]") + "\n"
        if dice.random() < 0.5:
            text += f"dissipation sum({of(number(), 'u[i]^2')}*q[i]'^2/20, i = 1..N)\n"
        if dice.random() < 0.5:
            pull = of("s", "u[i]", "sin(t)", f"sum(sin({near} - q[j]), j = {of('1..N', '1..i')})/N")
            text += f"force q[i = {of('1..N', '2..N-1', '3..3')}] = {pull}*w[i]/4\n"
    mixed = ("s", "k*w[i]", f"sin({near})", "exp(-u[i]^2)*cos(t)", *(["q[i]'"] * coordinates))
    over = of("1..N", "i+1..N", "2..N-1")
    all_ = of("", f" + k*sum(w[j]*sin(u[j] - u[i]) + {near}*u[j], j = {over})/N")
    spread = of("1", "w[i]") + "*(u[i-1] - 2*u[i] + u[i+1])"
    first = of("", f"rate u[1] = -u[1] + {of('s', 'sin(t)')}\n")
    begin = 2 if first else 1
    text += first + f"rate u[i = {begin}..N] = {spread} - u[i]^3 + {of(*mixed)}{all_}\n"
    felt = ("sin(t)", "u[2]", "sum(w[i]*u[i]^2, i = 1..N)/N", *(["X", "q[1]"] * coordinates))
    text += f"rate s = -s*{number()} + {of(*felt)}\n"
    text += "start u[i = 1..N] = cos(i)\nstart s = 0.4\n"
    text += "start q[i = 1..N] = 0.3*sin(2*i)\nstart q[2]' = 0.5\n" if coordinates else ""
    text += "observe total = sum(u[i]^2, i = 1..N) + s*t\n"
    return (
        text + f"event near: {of('u[3] - s', 'sum(u[i], i = 1..N) - 1', 'u[N]*s - 0.1')} either\n"
    )
