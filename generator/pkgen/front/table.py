"""The statements of the language, one row each; the clauses of scenes are statements too.

A row names the method in `check/` that checks the statement and defines its meaning.
"""

from __future__ import annotations

from ..record import record

MODEL, SCENE, BOTH = "a model", "a scene", "a model or a scene"
SAMPLE = "a sample block"
FIRST, ALL = "first", "all"

# The grammar after a statement's keyword. A key is also the name of a method of parse_build.Build.
SYNTAX = {
    "head": "NAME",
    "param": "left EQUAL item [interval]",
    "define": "left EQUAL item",
    "declare": "declared (_COMMA declared)*",
    "pairs": "pair (_COMMA pair)*",
    "names": "left (_COMMA left)*",
    "exact": "pair (_COMMA pair)* [within]",
    "holds": "(pair | left) (_COMMA (pair | left))*",
    "single": "item",
    "force": "(left [at] | point) EQUAL item",
    "equation": "left COLON item EQUAL item",
    "observe": "left (EQUAL item [while] | while)",
    "event": "NAME COLON test [direction] [STOP] [then]",
    "impact": "left COLON item (FALLING | RISING) [WITH] [restitution] [rubbing] [POISSON]",
    "contact": "left COLON item AT_LEAST item [restitution] [rubbing] [POISSON]",
    "friction": "left EQUAL item [static]",
    "mode": "NAME COLON CONSTRAINT left (_COMMA left)* [ON AT NAME] [OFF AT NAME]",
    "draw": "SHAPE [drawn] part* [_COMMA also]",
    "body": "several clause*",
    "joint": "several COLON end WORD end WORD [item] clause*",
    "start_at": "(start_item (_COMMA start_item)* | NAME)",
    "method": "NAME [TABLEAU FILE] [STEP item] [RTOL item]",
    "record": "item (_COMMA item)* [every] [at]",
    "table": "NAME EQUAL STRING column (_COMMA column)* [ARROW column] table_word*",
    "swarm": "range",
    "sample": "NAME every [offset] [delay]",
    "expect": "item relation item [within] [at]",
    "end_of_scene": "",
    "use": "STRING AS NAME [WITH pair (_COMMA pair)*]",
}

# Columns: keyword, key of SYNTAX, method that checks, field of Model, names that are declared,
# dimension of the expression, form (the syntax in hints).
_MODEL = """
model       head     definitions.model   name        -     -      NAME
param       param    definitions.param   parameters  first -      NAME = VALUE [unit] in (lo, hi)
size        define   definitions.size    sizes       first -      NAME = INTEGER
const       define   definitions.define  definitions first -      NAME = VALUE [unit]
let         define   definitions.define  definitions first -      NAME = EXPRESSION
observe     observe  definitions.define  observed    first -      NAME = EXPRESSION
conserve    define   definitions.define  conserved   first -      NAME = EXPRESSION
rate        define   states.rate         rates       -     -      NAME = EXPRESSION
table       table    tables.declare       tables      first -      NAME = "FILE" x [m], y [m] spline
coord       declare  coordinates.declare coordinates all   -      a, b [m], q[1..N] [rad]
input       declare  coordinates.declare inputs      all   -      NAME [unit]
state       declare  coordinates.declare states      all   -      NAME [unit]
rotation    declare  coordinates.declare rotations   all   -      NAME
fixed       pairs    coordinates.ends    ends        -     -      q[0] = VALUE
free        names    coordinates.ends    ends        -     -      q
periodic    names    coordinates.ends    ends        -     -      q
kinetic     single   dynamics.energy     kinetic     -     energy m/2*x'^2
potential   single   dynamics.energy     potential   -     energy m*g*x
lagrangian  single   dynamics.energy     lagrangian  -     energy m/2*x'^2 - m*g*x
hamiltonian single   dynamics.energy     hamiltonian -     energy p_x^2/(2*m) + m*g*x
dissipation single   dynamics.energy     dissipation -     power  b/2*x'^2
fast        single   dynamics.energy     fast        -     energy k/2*x^2
force       force    forces.force        forces      first -      COORDINATE = EXPRESSION
torque      force    forces.torque       loads       first -      BODY = [X, Y, Z]
noise       force    forces.noise        noises      -     -      COORDINATE = INTENSITY
constraint  equation constraints.equation constraints -    energy NAME: A = B
rolling     equation constraints.equation constraints -    power  NAME: A = B
event       event    dynamics.event      events      first -      NAME: EXPRESSION rising
impact      impact   contacts.impact     contacts    first energy NAME: GAP falling restitution e
contact     contact  contacts.contact    contacts    first energy NAME: GAP >= 0 restitution e
friction    friction contacts.friction   frictions   -     power  NAME = FORCE
mode        mode     contacts.mode       modes       first -      NAME: constraint a on at EVENT
body        body     bodies.body         definitions first -      NAME mass m inertia [Ix, Iy, Iz]
joint       joint    bodies.joint        definitions first -      NAME: A to B revolute [0, 1, 0]
gravity     single   bodies.gravity      definitions -     -      [0, 0, -g]
use         use      definitions.use     definitions first -      "FILE" as NAME with p = VALUE
set         pairs    definitions.set     definitions -     -      INPUT = EXPRESSION
draw        draw     drawings.draw       drawings    -     -      bob P radius 0.1 [m]
view        draw     drawings.view       views       -     -      plane xy width 2 [m]
sample      sample   samples.sample      samples     first -      NAME every 0.01 [s] delay 1
memory      define   -                   samples     -     -      NAME = VALUE [unit]
method      method   methods.declare     methods     -     -      NAME tableau FILE
start       start_at dynamics.start      starts      -     -      a = VALUE, a' = VALUE
exact       exact    exacts.exact        exacts      -     -      x = EXPRESSION of t
scene       head     scenes.check        scenes      first -      NAME
"""
# The statements of a sample block, besides the `end` that closes it.
IN_SAMPLE = frozenset(("memory", "let", "set"))
# These words are keywords only at the start of a statement; elsewhere they are names.
_SOFT = frozenset(("draw", "view", "fast", "body", "joint", "gravity", "torque", "hamiltonian"))
# These words are keywords only at the start of a line, and only before a name or a string.
_BEFORE_NAME = frozenset(
    ("table", "use", "sample", "memory", "exact", "impact", "contact", "friction", "mode", "noise")
)
# Columns: keyword, key of SYNTAX, method that checks, how many a scene may have, form.
_SCENE = """
start    start_at     given.start    many a = VALUE, a' = VALUE
set      pairs        given.set      many p = VALUE
hold     holds        given.hold     many a = EXPRESSION
until    single       scene.until    one  5 [s]
accuracy single       scene.accuracy one  1e-9
method   method       scene.method   one  rk4 step 0.01 [s]
record   record       scene.record   one  a, energy every 0.01 [s]
swarm    swarm        scene.swarm    many k = 1..1000
expect   expect       scene.expect   many A = B within 1e-6 at 2 [s]
exact    exact        scene.exact    many x = EXPRESSION of t
end      end_of_scene scene.end      many
"""


@record(kw_only=True)
class Statement:
    syntax: str  # A key of SYNTAX.
    form: str  # The statement's syntax, for hints.
    check: str = ""  # GROUP.METHOD that checks the statement in a model, or "".
    clause: str = ""  # GROUP.METHOD that checks the clause in a scene, or "".
    declares: str = ""  # Which of its names the statement declares: FIRST, ALL or "".
    fills: str = ""  # The field of Model for the results of the check.
    needs: str = ""  # Dimension of the expression: "energy", "power" or "" (any).
    once: bool = False  # A scene has at most one such clause.
    soft: bool = False  # Inside of statements the keyword can be a name.
    before_name: bool = False  # The keyword is one only before a name or a string.

    @property
    def stands_in(self) -> str:
        if not self.check and not self.clause:
            return SAMPLE
        return BOTH if self.check and self.clause else SCENE if self.clause else MODEL


def _statements() -> dict[str, Statement]:
    rows: dict[str, dict] = {}
    for line in _MODEL.strip().split("\n"):
        word, syntax, check, fills, declares, needs, form = line.split(maxsplit=6)
        rows[word] = {"syntax": syntax, "fills": fills, "form": f"{word} {form}"}
        rows[word] |= {"check": check.strip("-")}
        rows[word] |= {"declares": declares.strip("-"), "needs": needs.strip("-")}
        rows[word] |= {"soft": word in _SOFT | _BEFORE_NAME, "before_name": word in _BEFORE_NAME}
    for line in _SCENE.strip().split("\n"):
        word, syntax, clause, count, *form = line.split(maxsplit=4)
        own = {"syntax": syntax, "clause": clause, "form": " ".join([word, *form])}
        rows[word] = rows.get(word, {}) | own | {"once": count == "one"}
    return {word: Statement(**row) for word, row in rows.items()}


STATEMENTS = _statements()


def grammar() -> str:
    """Returns the grammar rule of a statement, and its keywords as terminals."""
    words = {word.upper(): row.syntax for word, row in STATEMENTS.items()}
    ways = [
        f"({' | '.join(word for word in words if words[word] == syntax)}) {rule} -> {syntax}"
        for syntax, rule in SYNTAX.items()
    ]
    return "?statement: " + "\n    | ".join(ways) + f"\n%declare {' '.join(words)}\n"
