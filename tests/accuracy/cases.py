"""The test set of `accuracy`: what is asked of which model. Everything in models/ is here, and of
each class of motion something short and something long, loose and tight."""

from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
SCENE = "judged"


@dataclass(frozen=True)
class Case:
    """A model's file and the body of its scene; `quick` ones are in `make test`."""

    name: str
    model: str
    body: str
    quick: bool = False

    @property
    def path(self) -> Path:
        return (
            next(
                p
                for p in (ROOT / "models", ROOT / "tests/regimes/models", HERE)
                if (p / self.model).exists()
            )
            / self.model
        )

    def text(self) -> str:
        """The model with the scene behind it."""
        clauses = "\n".join(f"  {clause.strip()}" for clause in self.body.split(";"))
        return f"{self.path.read_text(encoding='utf-8')}\n\nscene {SCENE}\n{clauses}\nend\n"


CASES = (
    # models/
    Case("bead loose", "bead_on_hoop.lag", "until 10; accuracy 1e-4; record theta every 0.1"),
    Case(
        "bead tight",
        "bead_on_hoop.lag",
        "until 100; accuracy 1e-10; record theta, theta', energy every 0.5",
    ),
    Case(
        "oscillators",
        "coupled_oscillators.lag",
        "until 20; accuracy 1e-8; record q[1], q[2], q[3] every 0.1",
        quick=True,
    ),
    Case(
        "oscillators long",
        "coupled_oscillators.lag",
        "until 5000; accuracy 1e-6; record q[1], energy every 10",
    ),
    Case(
        "double pendulum loose",
        "double_pendulum.lag",
        "until 3; accuracy 1e-3; record theta1, theta2 every 0.02",
    ),
    Case(
        "double pendulum tight",
        "double_pendulum.lag",
        "until 5; accuracy 1e-11; record theta1, theta2, energy every 0.05",
    ),
    Case(
        "double pendulum small",
        "double_pendulum.lag",
        "start theta1 = 0.3, theta2 = 0.2, theta1' = 0, theta2' = 0; until 200; accuracy 1e-7; "
        "record theta1, theta2 every 1",
    ),
    Case(
        "double pendulum chaotic",
        "double_pendulum.lag",
        "start theta1 = 3.0, theta2 = 3.1; until 8; accuracy 1e-8; record theta1, theta2 every 0.1",
    ),
    Case(
        "double pendulum far too long",
        "double_pendulum.lag",
        "start theta1 = 3.0, theta2 = 3.1; until 60; accuracy 1e-8; "
        "record theta1, theta2 every 0.1",
    ),
    Case(
        "elastic pendulum",
        "elastic_pendulum.lag",
        "until 20; accuracy 1e-6; record s, theta every 0.05",
    ),
    Case(
        "elastic pendulum long",
        "elastic_pendulum.lag",
        "until 400; accuracy 1e-9; record s, theta, energy every 1",
    ),
    Case("heavy top", "heavy_top.lag", "until 10; accuracy 1e-9; record theta, phi every 0.05"),
    Case("heavy top loose", "heavy_top.lag", "until 30; accuracy 1e-4; record theta every 0.1"),
    Case(
        "stone at its apex",
        "particles/thrown_stone.lag",
        "until 7; accuracy 1e-9; record y, y' at apex",
    ),
    Case(
        "stone",
        "particles/thrown_stone.lag",
        "set k = 0.02; until 7; accuracy 1e-8; record y, y' every 0.05",
    ),
    Case("fput", "chains/fput.lag", "until 300; accuracy 1e-6; record q[1], q[16], energy every 1"),
    Case("fput tight", "chains/fput.lag", "until 60; accuracy 1e-10; record q[16] every 5"),
    # oscillators and pendulums
    Case("oscillator", "oscillator.lag", "until 50; accuracy 1e-12; record q every 1", quick=True),
    Case(
        "oscillator many rows",
        "oscillator.lag",
        "until 100; accuracy 1e-5; record q, q' every 0.01",
    ),
    Case("two masses", "two_masses.lag", "until 300; accuracy 1e-9; record x1, x2 every 0.5"),
    Case(
        "pendulum loose",
        "pendulum.lag",
        "until 20; accuracy 1e-3; record theta every 0.2",
        quick=True,
    ),
    Case(
        "pendulum", "pendulum.lag", "until 100; accuracy 1e-8; record theta every 0.5", quick=True
    ),
    Case("pendulum very long", "pendulum.lag", "until 20000; accuracy 1e-5; record theta every 50"),
    Case(
        "pendulum tight",
        "pendulum.lag",
        "start theta = 2.5; until 50; accuracy 1e-12; record theta, theta' every 0.5",
    ),
    Case("pendulum many rows", "pendulum.lag", "until 50; accuracy 1e-6; record theta every 0.005"),
    Case("pendulum end", "pendulum.lag", "until 1000; accuracy 1e-9; record theta every 1000"),
    Case(
        "cubic well", "cubic_well.lag", "start q = 0.4; until 500; accuracy 1e-7; record q every 1"
    ),
    Case("ramp", "ramp.lag", "until 60; accuracy 1e-9; record q every 0.3"),
    Case(
        "spherical pendulum",
        "spherical_pendulum.lag",
        "until 30; accuracy 1e-8; record theta, phi every 0.1",
    ),
    Case("foucault", "foucault.lag", "until 3600; accuracy 1e-7; record x, y every 10"),
    Case(
        "triple pendulum",
        "triple_pendulum.lag",
        "until 10; accuracy 1e-7; record a, b, c every 0.1",
    ),
    # orbits
    Case(
        "kepler",
        "kepler.lag",
        "set e = 0.2; until 60; accuracy 1e-6; record x, y every 0.5",
        quick=True,
    ),
    Case(
        "kepler eccentric",
        "kepler.lag",
        "set e = 0.9; until 30; accuracy 1e-8; record x, y every 0.1",
    ),
    Case(
        "kepler eccentric loose",
        "kepler.lag",
        "set e = 0.9; until 100; accuracy 1e-3; record x, y every 1",
    ),
    Case(
        "kepler long", "kepler.lag", "set e = 0.1; until 3000; accuracy 1e-4; record x, y every 10"
    ),
    Case("planets", "planets.lag", "until 300; accuracy 1e-6; record x1, y1, x2, y2 every 1"),
    Case("arenstorf", "arenstorf.lag", "until 17; accuracy 1e-6; record x, y every 0.1"),
    Case(
        "henon heiles",
        "henon_heiles.lag",
        "start x = 0.1, y = 0.3, x' = 0.2; until 60; accuracy 1e-8; record x, y every 0.5",
    ),
    Case("quartic plane", "quartic_plane.lag", "until 200; accuracy 1e-8; record x, y every 1"),
    # tops
    Case(
        "free top",
        "free_top.lag",
        "start alpha' = 0.5, beta = 0.2, beta' = 0.3, psi' = 0.4; until 20; accuracy 1e-9; "
        "record alpha, beta, psi every 0.1",
    ),
    Case(
        "sleeping top",
        "sleeping_top.lag",
        "set p_spin = 2.6; start alpha = 0.1; until 100; accuracy 1e-6; "
        "record alpha, beta every 0.5",
    ),
    # driven and damped
    Case("duffing", "duffing.lag", "until 100; accuracy 1e-7; record q every 0.5", quick=True),
    Case("duffing long", "duffing.lag", "until 2000; accuracy 1e-4; record q, q' every 5"),
    Case(
        "kapitza",
        "kapitza.lag",
        "start theta = 0.1; until 20; accuracy 1e-6; record theta every 0.1",
    ),
    Case("circuit", "circuit.lag", "until 50; accuracy 1e-8; record a, b every 0.1"),
    Case("decay", "decay.lag", "until 10; accuracy 1e-10; record q, q' every 0.5", quick=True),
    # stiff
    Case("van der pol", "van_der_pol.lag", "until 30; accuracy 1e-6; record x every 0.1"),
    Case(
        "van der pol stiff",
        "van_der_pol.lag",
        "set mu = 1000; until 1500; accuracy 1e-4; record x every 10",
    ),
    Case("follow", "follow.lag", "until 10; accuracy 1e-6; record q every 0.1"),
    Case("stiff pair", "stiff_pair.lag", "until 10; accuracy 1e-5; record a every 0.1"),
    # not smooth
    Case("vee", "vee.lag", "until 20; accuracy 1e-5; record q every 0.1"),
    Case("drag", "drag.lag", "until 7; accuracy 1e-9; record y every 0.1"),
    # chains
    Case(
        "ring",
        "chain.lag",
        "start q[i = 1..N] = 0.5*cos(2*pi*i/N); until 50; accuracy 1e-6; "
        "record q[1], q[7] every 0.5",
    ),
    Case(
        "kink",
        "kink_chain.lag",
        "start q[20]' = 0.3; until 40; accuracy 1e-8; record q[20], energy every 0.5",
    ),
)
