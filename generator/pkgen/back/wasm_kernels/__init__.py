"""C functions `live_*` by which live pages and Python call a model, and the file that names it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...methods import Own
from ...own import in_c

LIVE = Path(__file__).parent
WHICH = "which-model.c"
SYSTEM = """#include <pk/system.h>
extern const struct pk_system {name}_system;
#include <pk/method.h>
{own}extern const struct pk_system *const live_system;
const struct pk_system *const live_system = &{name}_system;
extern const struct pk_method *const *const live_own;
const struct pk_method *const *const live_own = {methods};
extern const size_t live_own_count;
const size_t live_own_count = {count};
"""


def which_model(name: str, own: Sequence[Own] = ()) -> str:
    methods = "own_methods" if own else "0"
    return SYSTEM.format(name=name, own=in_c.rows(own), count=len(own), methods=methods)
