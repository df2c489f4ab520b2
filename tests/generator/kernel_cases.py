"""The systems whose kernels are compared with SymPy: parts of models, which both read."""

from building import parts_of_links

PLANE = "m/2*(x'^2 + y'^2)"
CASES = {
    "double_pendulum": dict(
        params={"m1": 1.21, "m2": 0.83, "l1": 1.37, "l2": 0.71, "g": 9.81},
        coords=("theta1", "theta2"),
        lets={
            "x1": "l1*sin(theta1)",
            "y1": "-l1*cos(theta1)",
            "x2": "x1 + l2*sin(theta2)",
            "y2": "y1 - l2*cos(theta2)",
        },
        kinetic="m1/2*(x1'^2 + y1'^2) + m2/2*(x2'^2 + y2'^2)",
        potential="m1*g*y1 + m2*g*y2",
    ),
    "coupled_oscillators": dict(
        sizes={"n": 3},
        params={"m": 1.21, "k": 2.3, "kc": "k*1.7"},
        coords=("q[1..n]",),
        kinetic="sum(m/2*q[i]'^2, i = 1..n)",
        potential="k/2*q[1]^2 + k/2*q[n]^2 + sum(kc/2*(q[i+1] - q[i])^2, i = 1..n-1)",
    ),
    "bead_on_hoop": dict(
        params={"m": 1.3, "R": 0.9, "Omega": 4.3, "g": 9.81},
        coords=("theta",),
        lets={
            "x": "R*sin(theta)*cos(Omega*t)",
            "y": "R*sin(theta)*sin(Omega*t)",
            "z": "-R*cos(theta)",
        },
        kinetic="m/2*(x'^2 + y'^2 + z'^2)",
        potential="m*g*z",
    ),
    "elastic_pendulum": dict(
        params={"m": 1.3, "l0": 0.8, "g": 9.81, "k": "3*m*g/l0"},
        coords=("s", "theta"),
        lets={"x": "(l0 + s)*sin(theta)", "y": "-(l0 + s)*cos(theta)"},
        kinetic=PLANE,
        potential="m*g*y + k/2*s^2",
    ),
    "heavy_top": dict(
        params={"I1": 1.3, "I3": 0.6, "M": 0.9, "l": 1.1, "g": 9.81},
        coords=("phi", "theta", "psi"),
        kinetic="I1/2*(theta'^2 + phi'^2*sin(theta)^2) + I3/2*(psi' + phi'*cos(theta))^2",
        potential="M*g*l*cos(theta)",
    ),
    "charge": dict(
        params={"m": 1.3, "e": 0.7, "B": 2.1, "E": 0.4},
        coords=("x", "y", "z"),
        lagrangian=(
            "m/2*(x'^2 + y'^2 + z'^2)",
            "e*(dot([-B*y/2, B*x/2, B*x^2/3], [x', y', z']) + E*x*z)",
        ),
    ),
    "shaken": dict(
        params={"m": 1.3, "l": 0.7, "g": 9.81, "a": 0.2, "w": 3.1},
        coords=("theta",),
        lets={"x": "a*sin(w*t) + l*sin(theta)", "y": "a*t^2/3 - l*cos(theta)"},
        kinetic=PLANE,
        potential="m*g*y",
    ),
    "relativistic": dict(
        params={"m": 1.3, "c": 3.7, "k": 0.4},
        coords=("x", "y"),
        lagrangian="-m*c^2*sqrt(1 - (x'^2 + y'^2)/c^2)",
        potential="k/4*(x^2 + y)^2",
    ),
    "driven": dict(
        params={"m": 1.3, "l": 0.7, "g": 9.81},
        coords=("theta",),
        inputs=("other", "u"),
        lets={"x": "u + l*sin(theta)", "y": "-l*cos(theta)"},
        kinetic=PLANE,
        potential="m*g*y",
    ),
    "cart": dict(
        params={"M": 2.3, "m": 1.3, "l": 0.7, "g": 9.81, "c": 0.3, "d": 0.2, "F": 1.7},
        coords=("s", "theta"),
        inputs=("u",),
        lets={"place": "[s + l*sin(theta), -l*cos(theta), 0]"},
        kinetic="M/2*s'^2 + m/2*dot(place', place')",
        potential="m*g*place.y",
        dissipation=("c/2*s'^2", "d/4*(theta' - s')^4*(2 + cos(theta))"),
        forces={"s": "F*cos(3*t) + u*theta", "theta": "m*s'*theta'"},
    ),
    "chain": dict(
        sizes={"N": 4},
        params={"m": 1.3, "k": 2.1, "a": 0.3, "w": 1.9},
        coords=("q[1..N]",),
        ends=("fixed q[0] = a*sin(w*t)", "free q[5]"),
        kinetic="sum(m/2*q[i]'^2, i = 1..N)",
        potential="sum(k/2*(q[i+1]-q[i])^2 + k/4*(q[i+1]-q[i])^4, i = 0..N)",
    ),
    "moved_end": dict(
        sizes={"N": 2},
        params={"m": 1.3, "k": 2.1, "a": 0.3, "w": 1.9},
        coords=("q[1..N]",),
        ends=("fixed q[0] = a*sin(w*t)",),
        lagrangian="sum(m/2*q[i]'^2, i = 1..N) + m/3*q[1]'*q[0]'*q[1] - k/2*(q[1] - q[0])^2",
    ),
    "ring": dict(
        sizes={"N": 5},
        params={"m": 1.3, "k": 2.1},
        coords=("q[1..N]",),
        ends=("periodic q",),
        kinetic="sum(m/2*q[i]'^2, i = 1..N)",
        potential="sum(k*(1 - cos(q[i+1] - q[i])), i = 1..N)",
    ),
    "kepler": dict(
        params={"m": 1.3, "k": 2.1},
        coords=("x", "y", "z"),
        lets={"r": "norm([x, y, z])"},
        kinetic="m/2*(x'^2 + y'^2 + z'^2)",
        potential="-k/r - k*exp(-r/3)*log(r) - k*(r - 2)^3",
    ),
    "functions": dict(
        params={"m": 1.3, "a": 1.7},
        coords=("x", "y"),
        kinetic="m/2*(2 + tanh(x*y) + atan(x/3)^2 + sinh(x/2)^2)*(x'^2 + x'*y' + 3*y'^2)",
        potential="tan(x/4) + asin(x/5)*acos(y/5) + atan2(y, 3+x) + cosh(y)"
        " + (4+x)^a + (5+y)^(5/2) + (3 + x*y/9)^(1/3)",
    ),
    "links": parts_of_links(3),
}
CLASSICAL = [
    "double_pendulum",
    "coupled_oscillators",
    "bead_on_hoop",
    "elastic_pendulum",
    "heavy_top",
]
