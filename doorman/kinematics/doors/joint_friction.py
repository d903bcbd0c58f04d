"""Friction of a simulated joint: what URDF and scenario say of it, else all that a usual hinge may have."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.kinematics.doors.door import Door
from doorman.scenario import Scenario

USUAL = 0.8, 0.6
"""Mean and deviation of a room door's friction [N m]."""


@dataclass(frozen=True)
class JointFriction:
    """Torques at α [N m]."""

    least: float
    expected: float
    """That of the plant, where nobody says another."""
    largest: float

    @property
    def known(self) -> bool:
        """Whether anybody says what it is."""
        return self.least == self.largest


def joint_friction(scenario: Scenario, door: Door, hinge_scale: float) -> JointFriction:
    """Of the plant's joint. A URDF's 0 is what its writer left out; a grip needs no friction, and takes it for 0."""
    true = scenario.simulation.door_friction
    told = door.friction if true is None else door.per_angle * true
    if true is not None or told > 0.0 or scenario.door.friction is not None or scenario.contact.kind == "grip":
        return JointFriction(told, told, told)
    mean, deviation = (hinge_scale * each for each in USUAL)
    return JointFriction(mean - deviation, mean, mean + deviation)
