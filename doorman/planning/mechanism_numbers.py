"""Numbers of a door's mechanism; which there are says how its leaf moves, as `mechanism_in_symbols` understands them."""

from __future__ import annotations

from numpy.typing import ArrayLike

from doorman.kinematics.vehicles.vehicle import GRAVITY
from doorman.model import Model


def mechanism_numbers(model: Model) -> dict[str, ArrayLike]:
    """Geometry and weight of a scenario's door and contact, by the names of the whole-body task."""
    door, coupling = model.door, model.coupling
    return {
        "mechanism.origin": door.hinge_position, "mechanism.point": coupling.contact_point(0.0),
        "mechanism.normal": -door.normal(0.0), "mechanism.along": door.leaf_direction(0.0),
        "mechanism.hand": door.hand, "mechanism.across": door.along,
        **_of_no_plumb_hinge(model),
    }  # fmt: skip


def _of_no_plumb_hinge(model: Model) -> dict[str, ArrayLike]:
    """How α moves a leaf that does not turn about a vertical, and its weight, which does nothing to one that does."""
    door = model.door
    if door.vertical:
        return {}
    moves: dict[str, ArrayLike] = (
        {"mechanism.slide": door.lever(0.0, model.coupling.distance_from_hinge)}
        if door.slides
        else {"mechanism.axis": door.hand * door.up}
    )
    return {**moves, "mechanism.weight": door.mass * GRAVITY, "mechanism.center": door.center_of_mass(0.0)}
