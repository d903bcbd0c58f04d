"""A latch in the plant: it holds the leaf while that is shut and nothing turns the lever."""

from __future__ import annotations

import math
from typing import Any

from doorman.model import Model
from doorman.simulation.plant.assembly import DOOR

_ENGAGED = math.radians(0.5)
"""A leaf that is open by more is beside its strike plate [rad or m]."""


class Latch:
    """Friction of the leaf's joint while the bolt is out; the model's door has a latch."""

    def __init__(self, model: Model, engine_model: Any, data: Any) -> None:
        door, section = model.true_door, model.true_door.section
        assert section.latch is not None
        self._latch, leaf, self._closed = section.latch, section.hinge, door.closed
        if self._latch.joint == section.hinge:  # a step that turns the lever: the leaf that carries it stands beside
            leaf, self._closed = section.beside[0].joint, section.beside[0].value
        lever, hinge = (engine_model.joint(DOOR + name) for name in (self._latch.joint, leaf))
        self._lever, self._leaf, self._index = int(lever.qposadr[0]), int(hinge.qposadr[0]), int(hinge.dofadr[0])
        self._places, self._frictions = data.qpos, engine_model.dof_frictionloss
        self._free = float(self._frictions[self._index])

    def act(self) -> None:
        """Set this step's friction of the leaf's joint."""
        turned = abs(float(self._places[self._lever]) - self._latch.closed)
        shut = abs(float(self._places[self._leaf]) - self._closed) < _ENGAGED
        held = self._latch.holds if shut and turned < self._latch.opens_at else 0.0
        self._frictions[self._index] = self._free + held
