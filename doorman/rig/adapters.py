"""What the emulators see of the rig's plant: a vehicle, an arm with its gripper, and a body for the cameras."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.hardware.vehicle.gripper import CLOSED, OPEN, SHUT
from doorman.kinematics.quaternions import from_rotation, multiply, to_attitude
from doorman.kinematics.rotations import quaternion_of
from doorman.rig.emulators.autopilot.estimator import PlantTruth
from doorman.rig.emulators.mocap.emulator import BodyPose
from doorman.rig.emulators.servos.bus import LaggingJoints, ServoMotion
from doorman.rig.plant import RigPlant, Snapshot

TORQUE_PER_CURRENT = 2.6
"""Torque of an XH430-W350 per current: 3.4 N m at 1.3 A [N m/A]."""
_FARTHEST = 0.02
"""A snapshot is carried on to another time by this much at most [s]."""


class RigVehicle:
    def __init__(self, plant: RigPlant) -> None:
        self._plant = plant

    @property
    def weight(self) -> float:
        return self._plant.model.vehicle.weight

    def command(self, thrust: float, quaternion: Array, side_force: tuple[float, float] = (0.0, 0.0)) -> None:
        """Fly with a thrust, and a force to the side, towards an attitude, until the next command."""
        attitude = np.array(to_attitude((quaternion / np.linalg.norm(quaternion)).tolist()))
        self._plant.fly(max(0.0, thrust), attitude, side_force)

    def stop_motors(self) -> None:
        self._plant.stop_motors()

    def advance(self, duration: float) -> None:
        """Do nothing: the plant advances by itself."""

    def truth(self) -> PlantTruth:
        snapshot = self._plant.snapshot
        truth = snapshot.truth
        return PlantTruth(
            truth.position,
            truth.velocity,
            np.array(quaternion_of(truth.attitude.tolist())),
            truth.body_rates,
            snapshot.on_ground,
        )


class RigArm:
    """The plant as the emulated servos move it; with a gripper, its servo is the last one."""

    def __init__(self, plant: RigPlant, gripper: bool) -> None:
        self._plant = plant
        self._n = plant.model.n_arm
        self._gripper = LaggingJoints(np.full(1, OPEN), stops=(OPEN, SHUT)) if gripper else None

    def drive(self, time: float, rates: Array, powered: NDArray[np.bool_]) -> None:
        """Take goal rates; a joint that nothing drives stands still, since its gears do not turn freely."""
        self._plant.move_arm(np.where(powered, rates, 0.0)[: self._n])
        if self._gripper is not None:
            self._gripper.drive(time, rates[self._n :], powered[self._n :])

    def motion(self, time: float) -> ServoMotion:
        snapshot = self._plant.snapshot
        truth, ahead = snapshot.truth, _ahead(snapshot, time)
        angles = truth.arm_angles + ahead * truth.arm_rates
        currents = snapshot.arm_torques / TORQUE_PER_CURRENT
        if self._gripper is None:
            return ServoMotion(angles, np.array(truth.arm_rates), currents)
        fingers = self._gripper.motion(time)
        self._plant.grip(bool(fingers.angles[0] > CLOSED))
        return ServoMotion(
            np.append(angles, fingers.angles),
            np.append(truth.arm_rates, fingers.rates),
            np.append(currents, fingers.currents),
        )


def body_seen(plant: RigPlant, time: float) -> BodyPose:
    snapshot = plant.snapshot
    truth, ahead = snapshot.truth, _ahead(snapshot, time)
    turn = 0.5 * ahead * truth.body_rates
    quaternion = np.array(multiply(quaternion_of(truth.attitude), [1.0, *turn.tolist()]))
    return BodyPose(truth.position + ahead * truth.velocity, quaternion)


def leaf_seen(plant: RigPlant, time: float) -> BodyPose:
    door, snapshot = plant.model.true_door, plant.snapshot
    angle = snapshot.truth.door_angle + _ahead(snapshot, time) * snapshot.truth.door_rate
    return _pose_of(door.link_placements(angle)[door.section.leaf])


def frame_seen(plant: RigPlant, time: float) -> BodyPose:
    """What stands around the leaf: where the true door is against the map."""
    return _pose_of(plant.model.true_door.placement)


def _pose_of(placement: Array) -> BodyPose:
    return BodyPose(placement[:3, 3], from_rotation(placement[:3, :3]))


def _ahead(snapshot: Snapshot, time: float) -> float:
    return min(max(time - snapshot.at, -_FARTHEST), _FARTHEST)
