"""Models that are in no other collection: stiff, chaotic, driven, of first order, with kinks."""

from __future__ import annotations


def _states(rates: dict[str, str], starts: dict[str, float], until: float, every: float) -> str:
    names = ", ".join(rates)
    lines = ["model own", f"state {names}"]
    lines += [f"rate {name} = {rate}" for name, rate in rates.items()]
    lines.append("start " + ", ".join(f"{name} = {x}" for name, x in starts.items()))
    return "\n".join([*lines, *_scene(names, until, every)])


def _scene(names: str, until: float, every: float) -> list[str]:
    return ["scene s", f"  until {until}", f"  record {names} every {every}", "end", ""]


def _moving(body: str, names: str, until: float, every: float) -> str:
    return "\n".join(["model own", body.strip(), *_scene(names, until, every)])


USUAL = (1e-4, 1e-7, 1e-10)
ROBERTSON = {
    "a": "-0.04*a + 1e4*b*c",
    "b": "0.04*a - 1e4*b*c - 3e7*b^2",
    "c": "3e7*b^2",
}
OREGONATOR = {
    "a": "77.27*(b + a*(1 - 8.375e-6*a - b))",
    "b": "(c - (1 + a)*b)/77.27",
    "c": "0.161*(a - c)",
}
MODELS = (
    ("states", "logistic", _states({"x": "x*(1 - x)"}, {"x": 0.01}, 12, 0.5), USUAL),
    (
        "states",
        "predators",
        _states({"x": "x*(1.1 - 0.4*y)", "y": "y*(0.1*x - 0.4)"}, {"x": 10, "y": 5}, 60, 0.5),
        USUAL,
    ),
    (
        "states",
        "epidemic",
        _states({"S": "-0.3*S*I", "I": "0.3*S*I - 0.1*I"}, {"S": 0.999, "I": 1e-3}, 200, 2),
        USUAL,
    ),
    (
        "states",
        "nerve",
        _states(
            {"v": "v - v^3/3 - w + 0.5", "w": "0.08*(v + 0.7 - 0.8*w)"}, {"v": -1, "w": 1}, 200, 1
        ),
        USUAL,
    ),
    (
        "states",
        "brusselator",
        _states({"x": "1 + x^2*y - 4*x", "y": "3*x - x^2*y"}, {"x": 1.5, "y": 3}, 40, 0.2),
        USUAL,
    ),
    (
        "chaotic",
        "lorenz",
        _states(
            {"x": "10*(y - x)", "y": "x*(28 - z) - y", "z": "x*y - 8/3*z"},
            {"x": 1, "y": 1, "z": 1},
            12,
            0.1,
        ),
        (1e-3, 1e-6, 1e-8),
    ),
    (
        "chaotic",
        "roessler",
        _states(
            {"x": "-y - z", "y": "x + 0.2*y", "z": "0.2 + z*(x - 5.7)"},
            {"x": 1, "y": 1, "z": 0},
            100,
            0.5,
        ),
        (1e-3, 1e-6, 1e-9),
    ),
    (
        "chaotic",
        "three bodies",
        _moving(
            "coord x, y, u, v\nkinetic (x'^2 + y'^2 + u'^2 + v'^2)/2\n"
            "potential -1/sqrt(x^2 + y^2) - 0.3/sqrt(u^2 + v^2)"
            " - 0.3/sqrt((x - u)^2 + (y - v)^2 + 0.01)\n"
            "start x = 1, y' = 1, u = -1.6, v' = -0.75",
            "x, y, u, v",
            25,
            0.25,
        ),
        (1e-3, 1e-6, 1e-9),
    ),
    (
        "chaotic",
        "swinging masses",
        _moving(
            "coord r, theta\nkinetic 2*r'^2 + r^2*theta'^2/2\n"
            "potential 9.81*3*r - 9.81*r*cos(theta)\nstart r = 1, theta = 1.5",
            "r, theta",
            6,
            0.05,
        ),
        (1e-4, 1e-8),
    ),
    ("stiff", "robertson", _states(ROBERTSON, {"a": 1, "b": 0, "c": 0}, 40, 1), (1e-3, 1e-5, 1e-7)),
    (
        "stiff",
        "oregonator",
        _states(OREGONATOR, {"a": 1, "b": 2, "c": 3}, 300, 2),
        (1e-3, 1e-5, 1e-7),
    ),
    (
        "stiff",
        "relaxation",
        _states({"v": "200*(v - v^3/3 - w)", "w": "(v + 0.2)/2"}, {"v": -1.5, "w": -0.3}, 12, 0.1),
        (1e-3, 1e-6, 1e-8),
    ),
    (
        "stiff",
        "slow manifold",
        _states({"x": "-1e5*(x - cos(t)) - sin(t)", "y": "x - y"}, {"x": 1.5, "y": 0}, 10, 0.1),
        (1e-3, 1e-6, 1e-8),
    ),
    (
        "stiff",
        "stiff damper",
        _moving(
            "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential x^4/4 + 1e4*(x - y)^2/2\n"
            "dissipation 500*(x' - y')^2\nstart x = 1, y = 1.01",
            "x, y",
            20,
            0.1,
        ),
        (1e-3, 1e-6, 1e-9),
    ),
    (
        "stiff",
        "stiff spring",
        _moving(
            "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential 1e4*(sqrt(x^2 + y^2) - 1)^2/2 + y\n"
            "start x = 1.0003",
            "x, y",
            10,
            0.1,
        ),
        (1e-3, 1e-6, 1e-9),
    ),
    (
        "driven",
        "chirp",
        _moving(
            "coord x\nkinetic x'^2/2\npotential x^2/2 + x^4/8\ndissipation 0.05*x'^2\n"
            "force x = 0.4*sin(0.02*t^2)\nstart x = 0.2",
            "x, x'",
            120,
            1,
        ),
        USUAL,
    ),
    (
        "driven",
        "mathieu",
        _moving(
            "coord a\nkinetic a'^2/2\npotential -(1 + 0.3*cos(2.1*t))*cos(a)\nstart a = 0.3",
            "a, a'",
            60,
            0.5,
        ),
        USUAL,
    ),
    (
        "driven",
        "bell",
        _moving(
            "coord x\nkinetic x'^2/2\npotential x^2/2 + x^4/10\n"
            "force x = 3*exp(-((t - 11.3)/0.05)^2)\nstart x = 0.1",
            "x",
            30,
            0.5,
        ),
        USUAL,
    ),
    (
        "driven",
        "two beats",
        _moving(
            "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential x^2 + 1.1*y^2 + x*y^2/5\n"
            "force x = 0.1*cos(1.4*t)\nforce y = 0.1*sin(1.5*t)*sin(0.03*t)\nstart y = 0.5",
            "x, y",
            200,
            2,
        ),
        USUAL,
    ),
    (
        "kinks",
        "bounce on a spring",
        _moving(
            "coord y\nkinetic y'^2/2\npotential 9.81*y + 2000*min(y, 0)^2/2\nstart y = 0.7",
            "y, y'",
            10,
            0.1,
        ),
        USUAL,
    ),
    (
        "kinks",
        "drag of a fluid",
        _moving(
            "coord x\nkinetic x'^2/2\npotential x^2\nforce x = -0.4*x'*abs(x')\nstart x = 1",
            "x",
            20,
            0.2,
        ),
        USUAL,
    ),
    (
        "kinks",
        "square wave",
        _moving(
            "coord x\nkinetic x'^2/2\npotential x^2/2 + x^4/4\ndissipation 0.1*x'^2\n"
            "force x = 0.5*(2*step(sin(1.3*t)) - 1)\nstart x = 0.2",
            "x, x'",
            60,
            0.5,
        ),
        USUAL,
    ),
    (
        "rows at events",
        "section",
        _moving(
            "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential (x^2 + y^2)/2 + x^2*y - y^3/3\n"
            "event through: x rising\nstart y = 0.1, x' = 0.35",
            "y, y'",
            100,
            1,
        ).replace("every 1", "at through"),
        USUAL,
    ),
    (
        "the end alone",
        "closed orbit",
        _moving(
            "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential -1/sqrt(x^2 + y^2)\n"
            "start x = 0.5, y' = sqrt(3)",
            "x, y, x', y'",
            "20*pi",
            "20*pi",
        ),
        USUAL,
    ),
    (
        "the end alone",
        "swing that ends in the middle",
        _moving(
            "coord q\nkinetic q'^2/2\npotential -cos(q)\nstart q' = 1",
            "q",
            33.71500709,
            33.71500709,
        ),
        USUAL,
    ),
)
