"""All kinds of collision constraints, by short names, and which of them a task has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Literal

from doorman.collision.rows.arm import Arm
from doorman.collision.rows.corners import Corners
from doorman.collision.rows.jambs import Jambs
from doorman.collision.rows.kind import Kind
from doorman.collision.rows.lintel import Lintel
from doorman.collision.rows.lintel_edge import LintelEdge
from doorman.collision.rows.plane import PLANES

Surroundings = Literal["doorway", "corners", "wall", "panel", "face", "open"]
"""The vehicle is between the jambs all the way; it begins beside them; it stays before the wall; or beside what slides;
or before the face in whose plane a lever turns; or nothing stands around the leaf."""

ARM = "arm"
KINDS: Mapping[str, Kind] = MappingProxyType(
    {ARM: Arm(), "doorway": Jambs(), "corners": Corners(), "lintel": Lintel(), "lintel_edge": LintelEdge(), **PLANES}
)
"""Short name to rows. A new kind is a file beside `lintel`, a line here, and a word in `kinds_of`."""
Kinds = tuple[str, ...]
"""Short names of the kinds that a task has, in their order."""


def kinds_of(surroundings: Surroundings, lintel: bool = False) -> Kinds:
    """Kinds of a task with these surroundings, and with a lintel that vehicle or arm could reach."""
    above = ["lintel" if surroundings == "doorway" else "lintel_edge"] if lintel else []
    if surroundings == "face":  # a lever is no plane that a disc could be before
        return (ARM, "panel")
    around = [] if surroundings == "open" else [surroundings]
    return (ARM, "leaf", *around, *above)


IN_A_DOORWAY = kinds_of("doorway")
"""The paper's."""


def row_names(kinds: Kinds, points: Sequence[str], above: bool) -> tuple[str, ...]:
    """Names of all rows, in their order."""
    return tuple(name for kind in kinds for name in KINDS[kind].names(points, above))
