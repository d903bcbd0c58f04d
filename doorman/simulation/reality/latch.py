"""A latch in the plant: it holds the leaf while that is shut and nothing turns the lever."""

from __future__ import annotations

import math
from typing import Any

from doorman.kinematics.doors.door import Door
from doorman.model import Model
from doorman.simulation.plant.assembly import DOOR

_ENGAGED = math.radians(0.5)
"""A leaf that is open by more is beside its strike plate [rad or m]."""


class Latch:
    """Friction of the leaf's joint while the bolt is out; the model's door has a latch."""

    def __init__(self, model: Model, engine_model: Any, data: Any) -> None:
        door = model.true_door
        latch = door.section.latch
        assert latch is not None
        self._latch = latch
        leaf = latched_joint(door)
        self._closed = door.closed if leaf == door.section.hinge else _value_beside(door, leaf)
        lever, hinge = (engine_model.joint(DOOR + name) for name in (latch.joint, leaf))
        self._lever, self._leaf, self._index = int(lever.qposadr[0]), int(hinge.qposadr[0]), int(hinge.dofadr[0])
        self._places, self._frictions = data.qpos, engine_model.dof_frictionloss
        self._free = float(self._frictions[self._index])

    @property
    def holds(self) -> bool:
        """Whether the bolt is in its strike plate."""
        turned = abs(float(self._places[self._lever]) - self._latch.closed)
        shut = abs(float(self._places[self._leaf]) - self._closed) < _ENGAGED
        return shut and turned < self._latch.opens_at

    @property
    def index(self) -> int:
        """Index of the leaf's joint in qvel."""
        return self._index

    def act(self) -> float:
        """Set this step's friction of the leaf's joint, and say how much of it is the latch's [N m, or N]."""
        held = self._latch.holds if self.holds else 0.0
        self._frictions[self._index] = self._free + held
        return held


def latched_joint(door: Door) -> str:
    """Joint that the latch holds: the door's own, or in a step before it the one that carries the lever."""
    latch = door.section.latch
    assert latch is not None
    return door.section.hinge if latch.joint != door.section.hinge else door.section.beside[0].joint


def _value_beside(door: Door, joint: str) -> float:
    return next(each.value for each in door.section.beside if each.joint == joint)
