"""Random chains of links whose places are defined from the former link's, one value at a time."""

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


# Constraints beside a chain: of the places of its links and of others, for each member or once.
ROWS = (
    "constraint held: {x:N}^2 + {y:N} = w + t",
    "constraint low: {x:N} - 0.4*{y:N}*{x:2} = w",
    "constraint mean: sum({x:i}*(1 + i/N), i = 1..N) + q[1]^2 = w*t",
    "rolling slip: ({x:N})'*cos(q[N]) + ({y:N})'*sin(q[N]) + 0.3*r[1]' = w",
    "rolling all: sum(({x:i})'*cos(i) + ({y:i})'*r[i], i = 1..N) = w",
)
EACH = (
    "constraint rail[i = 1..N]: r[i] + 0.2*sin({x:i}) + 0.1*r[i]*{y:i} = w",
    "constraint tie[i = 1..N]: ({x:i} - r[i])^2 + ({y:i} - 2*r[i] - i)^2 = w + t",
    "constraint way[i = 2..N]: r[i] + 0.3*r[i-1] + 0.2*{x:i}*{x:i-1} = w*sin(t)",
    "rolling blade[i = 1..N]: ({x:i})'*sin(q[i]) - ({y:i})'*cos(q[i]) + r[i]' = w/i",
    "rolling wheel[i = 1..N]: ({x:i})'*cos(q[i]) + ({y:i})'*sin(q[i]) = w*t",
)
BEYOND = ("free q\n", "free q[0]\nfixed q[N+1] = 0.2*t\n", "periodic q\n")


def tied_links(dice: random.Random, tied: bool = True) -> str:
    """A chain with rows of constraints, and with inertia across ends that are free or periodic;
    at least one of these where it is to be `tied`. r is a family beside it, w an input that is in
    every row."""
    text = links(dice).replace("model links", "model tied").replace("r[", "o[")
    start = text.index("start ")
    text, start = text[:start], text[start:]
    across = dice.random() < 0.4 and "fixed q[0]" not in text
    if across:
        if "q\n" not in text and "q[0]" not in text:
            text += dice.choice(BEYOND)
        text += dice.choice(
            (
                "kinetic sum((q[i]' - q[i-1]')^2/9, i = 1..N)\n",
                "kinetic sum((1 + cos(q[i]))*(q[i+1]' - q[i]')^2/9, i = 1..N)\n",
                "kinetic sum((2*q[i]' + q[i-1]' + q[i+1]')^2/9, i = 1..N)\n",
            )
        )
    text += "input w\ncoord r[1..N]\n"
    text += dice.choice(("", "free r\n", "periodic r\n", "fixed r[0] = 0.1*t\n"))
    text += "kinetic sum((1 + i/N)*r[i]'^2/2, i = 1..N)\n"
    text += "potential sum(r[i]^2*q[i] + r[i]^4/4, i = 1..N)\n"
    place = {"x": "o[{}].x", "y": "o[{}].y"} if "let o[" in text else {"x": "x[{}]", "y": "y[{}]"}
    rows = [dice.choice(EACH)] * (dice.random() < 0.5)
    others = ROWS[3:4] if "wheel" in "".join(rows) else ROWS  # wheels leave r alone
    rows += [dice.choice(others)] * (dice.random() < 0.6)
    if not (rows or across):
        rows = [ROWS[0]]
    rows = rows if tied else []
    for row in rows:
        text += row.format(x=_Place(place["x"]), y=_Place(place["y"])) + "\n"
    if rows:
        name = rows[0].split()[1].rstrip(":").split("[")[0]
        index = "[2]" if "[i" in rows[0].split(":")[0] else ""
        text += f"observe pull = lambda_{name}{index} + q[1]'\n"
    return text + start


class _Place:
    """Formats as the place of a link."""

    def __init__(self, form: str):
        self.form = form

    def __format__(self, at: str) -> str:
        return f"({self.form.format(at)})"


def held(dice: random.Random, size: int = 6) -> str:
    """A chain that hangs with its end held, perhaps with sleeves that its links' places move, and
    with coupled rates around its end; at rest on its constraints."""
    angle = f"{dice.uniform(0.2, 0.9):.3f}"
    text = f"model held\nsize N = {size}\nparam l = 0.7\nparam c = {angle}\ncoord q[1..N]\n"
    ring = dice.random() < 0.5
    text += dice.choice(("periodic q\n", "free q\n")) if ring else ""
    cart = dice.random() < 0.5
    text += "coord X\nkinetic X'^2\npotential 2*X^2\n" if cart else ""
    text += f"let x[0] = {'X' if cart else '0'}\nlet y[0] = {dice.choice(('0', 'sin(t)^2/9'))}\n"
    text += "let x[i = 1..N] = x[i-1] + l*sin(q[i])\nlet y[i = 1..N] = y[i-1] - l*cos(q[i])\n"
    text += "kinetic sum((1 + i/N)*(x[i]'^2 + y[i]'^2)/2, i = 1..N)\n"
    text += "potential sum(9.81*(1 + i/N)*y[i], i = 1..N)\n"
    text += "kinetic sum((q[i]' - q[i-1]')^2/9, i = 1..N)\n" if ring else ""
    text += "force q[i = 1..N] = -0.1*q[i]'\n" if dice.random() < 0.5 else ""
    rows = dice.choice(("xy", "x", "y", "r"))
    kept = (
        f"observe pull = lambda_{'far' if 'x' in rows else 'low' if 'y' in rows else 'rail[2]'}\n"
    )
    if dice.random() < 0.5 or rows == "r":
        text += "coord r[1..N]\nkinetic sum(r[i]'^2/2, i = 1..N)\npotential sum(r[i]^4, i = 1..N)\n"
        text += "constraint rail[i = 1..N]: r[i] + r[i]^3/9 = 0.2*(y[i] + i*l*cos(c)) + x[i]*r[i]\n"
    text += "constraint far: x[N] = sin(t)^2/5\n" if "x" in rows else ""
    text += "constraint low: y[N] = -N*l*cos(c)\n" if "y" in rows else ""
    return text + kept + "observe tip = x[3] + y[N]'\nstart q[i = 1..N] = c*cos(pi*i)\n"


def turned(dice: random.Random) -> str:
    """A chain of rigid bodies, each held at a point of the one before, in space."""
    text = "model turned\nsize N = 3\nparam l[i = 1..N] = 1 + 0.2*sin(i)\nrotation R[1..N]\n"
    text += "param m[i = 1..N] = 1 + 0.3*cos(i) in (0, inf)\ncoord X\nkinetic X'^2\npotential X^2\n"
    first = dice.choice(("[X, 0, 0.1*sin(t)^2]", "[0, 0, 0]", "[0, X*cos(t), X]"))
    text += f"let r[0] = {first}\n"
    bone = dice.choice(("[0, 0.1, -l[i]]", "[0.2*X, 0, -l[i]]", "[l[i], 0, 0.3*sin(t)^2]"))
    text += f"let r[i = 1..N] = r[i-1] + R[i]*{bone}\n"
    text += "kinetic sum(m[i]/2*(r[i].x'^2 + r[i].y'^2 + r[i].z'^2), i = 1..N)\n"
    text += (
        "kinetic sum(0.1*omega(R[i]).x^2 + 0.2*omega(R[i]).y^2 + 0.15*omega(R[i]).z^2, i = 1..N)\n"
    )
    text += "potential sum(9.81*m[i]*r[i].z, i = 1..N)\n"
    if dice.random() < 0.5:
        text += "potential sum(dot(R[i]*[1, 0, 0], R[i-1]*[0, 1, 0]), i = 2..N)/3\n"
    rows = dice.choice(("", "rolling slides: r[N].x' + X' = 0\n", "rolling flat: r[N].z' = 0\n"))
    text += rows + "observe tip = r[N].x + r[N].y' + energy\n"
    if rows:
        text += f"observe pull = lambda_{rows.split()[1].rstrip(':')}\n"
    text += "start R[i = 1..N] = rot([1, 0.2*i, 0], 0.3*i)\n"
    return text + ("" if rows else "start omega(R[i = 1..N]) = [0.3, 0.1*i, 0.2]\n")
