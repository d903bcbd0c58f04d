r"""What holds a leaf beside its hinge's friction: seal, latch, the weight of a leaning leaf, and play in the hinge.

For the opening o of a leaf of mass m whose centre is r from the hinge:

* A seal adds its torque to the friction while \|o\| is below its angle.
* A sprung catch turns the leaf by :math:`-\tau_l\,o/o_l` while \|o\| is below o_l, and by nothing beyond: it snaps open, and
  catches a leaf that comes back.
* A hinge that leans by l = (l_x, l_y) turns the leaf as the force :math:`m g\,l` at its centre does. Its geometry stays upright.
* With play b, friction acts through an element that has it: a spring beyond :math:`\pm b/2`, which slips at the friction's
  torque.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.kinematics.doors.door import Door
from doorman.scenario import SimulationSection

_WINDS_UP = 1e-3
"""Angle at which the spring behind the play slips [rad]."""


class DoorCatches:
    """What holds the leaf of one door beside its friction."""

    def __init__(self, simulation: SimulationSection, door: Door, friction: float, weight_lever: float) -> None:
        self._true, self._door, self._friction = simulation, door, friction
        self._pull = weight_lever * np.array([*simulation.door_lean, 0.0])
        self._leans = bool(self._pull.any())
        self._slipped: float | None = None

    @property
    def have_play(self) -> bool:
        """Whether friction acts here, through the play, and not in the joint."""
        return self._true.door_backlash > 0.0

    def friction(self, door_angle: float) -> float:
        """Friction of the seal, beside the hinge's [N m]."""
        sealed = abs(self._door.opening_of(door_angle)) < self._true.door_seal_angle
        return self._true.door_seal if sealed else 0.0

    def torque(self, door_angle: float) -> float:
        """Torque of latch, weight and play, positive for growing α; call it once a step [N m]."""
        door, true = self._door, self._true
        opening = door.opening_of(door_angle)
        torque = 0.0
        if true.door_latch > 0.0 and abs(opening) < true.door_latch_angle:
            torque += door.torque_of_closer(-true.door_latch * opening / true.door_latch_angle)
        if self._leans:
            torque -= float(self._pull @ door.normal(door_angle))
        return torque + self._behind_play(door_angle) if self.have_play else torque

    def _behind_play(self, door_angle: float) -> float:
        """Friction that acts through the play, against the motion, positive for growing α [N m]."""
        if self._friction == 0.0:
            return 0.0
        free = 0.5 * self._true.door_backlash
        slipped = door_angle if self._slipped is None else self._slipped
        away = door_angle - slipped
        if abs(away) > free + _WINDS_UP:
            slipped = door_angle - math.copysign(free + _WINDS_UP, away)
        self._slipped = slipped
        away = door_angle - slipped
        wound = math.copysign(max(abs(away) - free, 0.0), away)
        return -self._friction * wound / _WINDS_UP


def has_catches(simulation: SimulationSection) -> bool:
    """Whether anything but the hinge holds the leaf."""
    held = simulation.door_seal > 0.0 or simulation.door_latch > 0.0 or simulation.door_backlash > 0.0
    return held or any(simulation.door_lean)
