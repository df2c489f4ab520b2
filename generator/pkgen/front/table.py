"""The statements of the language, one row each; a clause of a scene is a statement too.

What a statement means is its check: a method of a class of `check/`, by name.
"""

from __future__ import annotations

from ..record import record

MODEL, SCENE, BOTH = "a model", "a scene", "a model or a scene"
NONE, FIRST, ALL = "", "first", "all"


@record(kw_only=True)
class Statement:
    rule: str  # of the grammar, behind the word
    kind: str  # what parse_build.py makes of it
    form: str  # as a hint shows it
    check: str = ""  # in a model: the method that gives it its meaning
    clause: str = ""  # in a scene
    declares: str = ""  # which names of one that does not parse it would have declared
    place: str = ""  # where its expression stands: of check/scope.py
    fills: str = ""  # the field of the Model
    needs: str = ""  # the dimension of its expression: "energy", "power"
    once: bool = False  # a scene has one of it
    soft: bool = False  # its word is one at the start of a statement alone, and else a name

    @property
    def stands_in(self) -> str:
        return BOTH if self.check and self.clause else SCENE if self.clause else MODEL


_DEFINE = {"rule": "left EQUAL item", "kind": "define", "declares": FIRST}
_DECLARE = {
    "rule": "declared (_COMMA declared)*",
    "kind": "declare",
    "declares": ALL,
    "check": "coordinates.declare",
}
_ENDS = {"kind": "ends", "check": "coordinates.ends", "fills": "ends"}
_BARE = "bare_end (_COMMA bare_end)*"
_FIXED = "fixed_end (_COMMA fixed_end)*"
_ENERGY = {"rule": "item", "kind": "energy", "check": "dynamics.energy", "place": "energy"}
_EQUATION = {
    "rule": "left COLON item EQUAL item",
    "kind": "equation",
    "check": "constraints.equation",
    "place": "constraint",
    "fills": "constraints",
}

_DRAWN = {"rule": "SHAPE [drawn] part* [_COMMA also]", "kind": "draw", "soft": True}

STATEMENTS: dict[str, Statement] = {
    "model": Statement(
        rule="NAME", kind="model", form="model NAME", check="definitions.model", fills="name"
    ),
    "param": Statement(
        rule="left EQUAL item [interval]",
        kind="param",
        form="param NAME = VALUE [unit] in (lo, hi)",
        check="definitions.param",
        declares=FIRST,
        place="param",
        fills="parameters",
    ),
    "size": Statement(
        rule="left EQUAL item",
        kind="size",
        form="size NAME = INTEGER",
        check="definitions.size",
        declares=FIRST,
        place="size",
        fills="sizes",
    ),
    "const": Statement(
        **_DEFINE,
        form="const NAME = VALUE [unit]",
        check="definitions.define",
        place="const",
        fills="definitions",
    ),
    "let": Statement(
        **_DEFINE,
        form="let NAME = EXPRESSION",
        check="definitions.define",
        place="let",
        fills="definitions",
    ),
    "observe": Statement(
        **_DEFINE,
        form="observe NAME = EXPRESSION",
        check="definitions.define",
        place="output",
        fills="observed",
    ),
    "conserve": Statement(
        **_DEFINE,
        form="conserve NAME = EXPRESSION",
        check="definitions.define",
        place="output",
        fills="conserved",
    ),
    "rate": Statement(
        **_DEFINE | {"declares": ""},  # of a name that is declared elsewhere
        form="rate NAME = EXPRESSION",
        check="states.rate",
        place="rate",
        fills="rates",
    ),
    "coord": Statement(**_DECLARE, form="coord a, b [m], q[1..N] [rad]", fills="coordinates"),
    "input": Statement(**_DECLARE, form="input NAME [unit]", fills="inputs"),
    "state": Statement(**_DECLARE, form="state NAME [unit]", fills="states"),
    "rotation": Statement(**_DECLARE, form="rotation NAME", fills="rotations"),
    "fixed": Statement(**_ENDS, rule=_FIXED, form="fixed q[0] = VALUE", place="fixed"),
    "free": Statement(**_ENDS, rule=_BARE, form="free q"),
    "periodic": Statement(**_ENDS, rule=_BARE, form="periodic q"),
    "kinetic": Statement(**_ENERGY, form="kinetic m/2*x'^2", needs="energy", fills="kinetic"),
    "potential": Statement(**_ENERGY, form="potential m*g*x", needs="energy", fills="potential"),
    "lagrangian": Statement(
        **_ENERGY, form="lagrangian m/2*x'^2 - m*g*x", needs="energy", fills="lagrangian"
    ),
    "dissipation": Statement(
        **_ENERGY, form="dissipation b/2*x'^2", needs="power", fills="dissipation"
    ),
    "force": Statement(
        rule="left EQUAL item",
        kind="force",
        form="force COORDINATE = EXPRESSION",
        check="dynamics.force",
        place="force",
        fills="forces",
    ),
    "constraint": Statement(**_EQUATION, form="constraint NAME: A = B", needs="energy"),
    "rolling": Statement(**_EQUATION, form="rolling NAME: A = B", needs="power"),
    "event": Statement(
        rule="NAME COLON item [direction] [STOP]",
        kind="event",
        form="event NAME: EXPRESSION rising",
        check="dynamics.event",
        declares=FIRST,
        place="event",
        fills="events",
    ),
    "draw": Statement(
        **_DRAWN,
        form="draw bob P radius 0.1 [m]",
        check="drawings.draw",
        declares=NONE,
        place="drawing",
        fills="drawings",
    ),
    "view": Statement(
        **_DRAWN,
        form="view plane xy width 2 [m]",
        check="drawings.view",
        declares=NONE,
        place="drawing",
        fills="views",
    ),
    "start": Statement(
        rule="start_item (_COMMA start_item)*",
        kind="start_at",
        form="start a = VALUE, a' = VALUE",
        check="dynamics.start",
        clause="given.start",
        place="start",
        fills="starts",
    ),
    "scene": Statement(
        rule="NAME",
        kind="scene",
        form="scene NAME",
        check="scenes.head",
        declares=FIRST,
        fills="scenes",
    ),
    "set": Statement(rule=_FIXED, kind="assign", form="set p = VALUE", clause="given.set"),
    "hold": Statement(
        rule="hold_item (_COMMA hold_item)*",
        kind="assign",
        form="hold a = EXPRESSION",
        clause="given.hold",
    ),
    "until": Statement(
        rule="item", kind="setting", form="until 5 [s]", clause="scene.until", once=True
    ),
    "accuracy": Statement(
        rule="item", kind="setting", form="accuracy 1e-9", clause="scene.accuracy", once=True
    ),
    "method": Statement(
        rule="NAME [STEP item] [RTOL item]",
        kind="method",
        form="method rk4 step 0.01 [s]",
        clause="scene.method",
        once=True,
    ),
    "record": Statement(
        rule="item (_COMMA item)* [every] [at]",
        kind="record",
        form="record a, energy every 0.01 [s]",
        clause="scene.record",
        once=True,
    ),
    "swarm": Statement(rule="range", kind="swarm", form="swarm k = 1..1000", clause="scene.swarm"),
    "expect": Statement(
        rule="item relation item [within] [at]",
        kind="expect",
        form="expect A = B within 1e-6 at 2 [s]",
        clause="scene.expect",
    ),
    "end": Statement(rule="", kind="end_of_scene", form="end", clause="scene.end"),
}


def grammar() -> str:
    """The rule of a statement, and the words as terminals."""
    ways: dict[tuple[str, str], list[str]] = {}
    for word, row in STATEMENTS.items():
        ways.setdefault((row.rule, row.kind), []).append(word.upper())
    lines = [f"({' | '.join(words)}) {rule} -> {kind}" for (rule, kind), words in ways.items()]
    words = " ".join(word.upper() for word in STATEMENTS)
    return "?statement: " + "\n    | ".join(lines) + f"\n%declare {words}\n"
