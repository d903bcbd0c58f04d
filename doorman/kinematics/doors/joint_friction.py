"""Friction of a simulated joint: what URDF and scenario say of it, else all that a usual hinge may have."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.kinematics.doors.door import Door
from doorman.scenario import Scenario
from doorman.scenario.sections.estimation import USUAL_HINGE


@dataclass(frozen=True)
class JointFriction:
    """Torques at α [N m]."""

    least: float
    expected: float
    """The plant's friction, where no file names another."""
    largest: float

    @property
    def known(self) -> bool:
        """Whether anybody says what it is."""
        return self.least == self.largest


def joint_friction(scenario: Scenario, door: Door, hinge_scale: float) -> JointFriction:
    """Friction of the plant's joint. A URDF's 0 counts as unknown."""
    true = scenario.simulation.door_friction
    named = door.friction if true is None else door.per_angle * true
    if true is not None or named > 0.0 or scenario.door.friction is not None:
        return JointFriction(named, named, named)
    mean, deviation = (hinge_scale * each for each in USUAL_HINGE["friction"])
    return JointFriction(mean - deviation, mean, mean + deviation)


def with_plants_friction(scenario: Scenario, friction: float) -> Scenario:
    """A scenario whose plant has this friction in the URDF's joint [N m, or N of a slide]."""
    plant = scenario.simulation.model_copy(update={"door_friction": friction})
    return scenario.model_copy(update={"simulation": plant})
