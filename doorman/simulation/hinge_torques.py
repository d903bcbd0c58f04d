"""Torques of the simulated hinge that MuJoCo's joint has no number for: preload, stiction, and what else holds a leaf."""

from __future__ import annotations

from doorman.exceptions import ScenarioError
from doorman.model import GRAVITY, Model
from doorman.simulation.plant import Plant
from doorman.simulation.reality.door_catches import DoorCatches, has_catches

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
        self._plant, self._told = plant, told
        self._catches = self._plant_catches(model, plant) if has_catches(true) else None
        self.other = 0.0
        """Of whatever else moves the leaf, in the sense of the URDF's joint [N m or N]."""

    def act(self) -> None:
        """Set this step's torque and friction."""
        self._applied[self._index] = self._preload + self.other
        if self._stiction > 0.0:
            stands = abs(self._rates[self._index]) < _STANDS
            self._frictions[self._index] = self._friction + (self._stiction if stands else 0.0)
        if self._catches is not None:
            self._catch(self._catches)

    def _catch(self, catches: DoorCatches) -> None:
        """Add what else holds the leaf."""
        angle = self._plant.door_angle
        if self._stiction == 0.0:
            self._frictions[self._index] = self._friction
        self._frictions[self._index] += catches.friction(angle)
        self._applied[self._index] += self._told.joint_torque(catches.torque(angle))

    def _plant_catches(self, model: Model, plant: Plant) -> DoorCatches:
        """Seal, latch, lean and play; where there is play, the joint's own friction acts through it."""
        engine_model, door = plant.engine_model, model.true_door
        if any(model.scenario.simulation.door_lean) and not door.vertical:
            raise ScenarioError(
                "only a hinge on a plumb axis can lean", file=model.scenario.source, field="simulation.door_lean",
                given=list(model.scenario.simulation.door_lean), allowed="[0.0, 0.0]",
            )  # fmt: skip
        leaf = int(engine_model.dof_bodyid[self._index])
        center = plant.data.subtree_com[leaf] - door.hinge_position
        lever = float(center @ door.leaf_direction(plant.door_angle))
        weight = float(engine_model.body_subtreemass[leaf]) * GRAVITY
        catches = DoorCatches(model.scenario.simulation, door, self._friction, weight * lever)
        if catches.have_play:
            self._friction = self._frictions[self._index] = 0.0
        return catches
