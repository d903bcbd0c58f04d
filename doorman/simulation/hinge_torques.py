"""Torques of the simulated hinge that MuJoCo's joint has no number for: a closer's preload, and stiction."""

from __future__ import annotations

from doorman.model import Model
from doorman.simulation.plant import Plant

_STANDS = 2e-4
"""A slower hinge sticks [rad/s]."""


class HingeTorques:
    """Applied before every physics step.

    Args:
        model: The model.
        plant: Its plant.
    """

    def __init__(self, model: Model, plant: Plant) -> None:
        told, true = model.true_door, model.scenario.simulation
        preload = told.section.preload if true.door_preload is None else true.door_preload
        self._stiction = told.section.stiction if true.door_stiction is None else true.door_stiction
        self._preload = -told.joint_torque(told.torque_of_closer(told.per_angle * preload))
        self._frictions, self._index = plant.engine_model.dof_frictionloss, plant.hinge_velocity
        self._friction = float(self._frictions[self._index])
        self._applied, self._rates = plant.data.qfrc_applied, plant.data.qvel
        self.other = 0.0
        """Of whatever else moves the leaf, in the sense of the URDF's joint [N m or N]."""

    def act(self) -> None:
        """Set this step's torque and friction."""
        self._applied[self._index] = self._preload + self.other
        if self._stiction > 0.0:
            stands = abs(self._rates[self._index]) < _STANDS
            self._frictions[self._index] = self._friction + (self._stiction if stands else 0.0)
