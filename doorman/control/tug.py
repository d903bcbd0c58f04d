"""What follows the touch: a tip presses, and a gripper is tried by a tug. A leaf that is not at its stop comes with it."""

from __future__ import annotations

from doorman.model import Model
from doorman.planning.pace import TUGGING

TUG = 0.05
"""Share of the weight with which a gripper is tried that has just closed, for `TUGGING`."""


def drawn_by_the_tug(model: Model, torque: float, friction: float) -> tuple[float, float]:
    """How far the tug of a tied tip draws a leaf from the start towards the vehicle, and its rate by then [rad], [rad/s].

    Torque of closer and weight in the sense of damping, and friction, are the true ones at the start.
    """
    lever, mass = model.coupling.lever_length, model.vehicle.mass
    net = max(model.contact.tied * TUG * model.vehicle.weight * lever - torque - friction, 0.0)
    rate = net / (model.door.inertia + mass * lever**2) * TUGGING
    way, room = 0.5 * rate * TUGGING, model.door.upper_limit - model.start_angle
    if model.door.endless or way < room:
        return way, rate
    return max(room, 0.0), 0.0
