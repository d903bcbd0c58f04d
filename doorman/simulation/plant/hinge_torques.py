"""Torques of the simulated hinge that MuJoCo's joint has no number for: preload, stiction, and what else holds a leaf."""

from __future__ import annotations

from doorman.exceptions import ScenarioError
from doorman.gravity import weight_of
from doorman.model import Model
from doorman.simulation.plant.plant import Plant
from doorman.simulation.plant.stepping import HingeNumbers
from doorman.simulation.reality.door_catches import DoorCatches, has_catches


class HingeTorques:
    """Torque, friction and stiction of the hinge's joint, as the stepping kernel reads them."""

    def __init__(self, model: Model, plant: Plant) -> None:
        door, true = model.true_door, model.scenario.simulation
        preload = door.section.preload if true.door_preload is None else true.door_preload
        stiction = door.section.stiction if true.door_stiction is None else true.door_stiction
        self._preload = -door.joint_torque(door.torque_of_closer(door.per_angle * preload))
        self._frictions, self._index = plant.engine_model.dof_frictionloss, plant.hinge_velocity
        self._friction = float(self._frictions[self._index])
        self._plant, self._door = plant, door
        self._catches = self._plant_catches(model, plant) if has_catches(true) else None
        self.numbers = HingeNumbers(torque=self._preload, friction=self._friction, stiction=stiction)

    @property
    def vary(self) -> bool:
        """Whether something holds the leaf that depends on where it is."""
        return self._catches is not None

    def act(self, other: float = 0.0) -> None:
        """Set this step's numbers."""
        self.numbers.torque = self._preload + other
        if self._catches is None:
            return
        angle = self._plant.door_angle
        self.numbers.friction = friction = self._friction + self._catches.friction(angle)
        self.numbers.torque += self._door.joint_torque(self._catches.torque(angle))
        self._frictions[self._index] = friction  # the kernel adds stiction, where there is some

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
        weight = weight_of(float(engine_model.body_subtreemass[leaf]))
        catches = DoorCatches(model.scenario.simulation, door, self._friction, weight * lever)
        if catches.have_play:
            self._friction = self._frictions[self._index] = 0.0
        return catches
