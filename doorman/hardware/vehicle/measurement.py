r"""Measurement from the newest samples of all links.

Position and velocity stay as they were measured, with the time at which they were true: the estimator behind it knows how to
use an old pose. The attitude is brought to that time, and the joint angles, which are not filtered, to the time of the tick,

.. math::
    q(t_p) = q_0 \exp(\Omega\,(t_p - t_0)), \qquad H(t) = H_0 + \dot H\,(t - t_0)

Body rates are the gyroscope's, unless the cameras' are younger altogether: the gyroscope's were true before the window over
which those are taken. Rates that stand still would pass for a gripper that lost the leaf.

A sample that is too old for that is an error, never a measurement; but the cameras replace an autopilot that is not heard for
a while.
"""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import ServoSample
from doorman.hardware.interface import Measurement
from doorman.hardware.mocap import PoseSample
from doorman.hardware.pixhawk import SampleStatus, VehicleSample
from doorman.hardware.vehicle.config import VehicleConfig
from doorman.kinematics.quaternions import multiply, to_attitude
from doorman.signals import FrameReading, LeafReading


def compose(
    now: float,
    opened: float,
    vehicle: VehicleSample,
    servos: ServoSample,
    pose: PoseSample | None,
    config: VehicleConfig,
    tip_force: float | None = None,
    leaf: LeafReading | None = None,
    frame: FrameReading | None = None,
) -> Measurement:
    n_arm, servo_patience = config.n_arm, config.servo_patience
    heard = vehicle.status is SampleStatus.FRESH
    if not heard and (pose is None or vehicle.status is not SampleStatus.STALE):
        raise BackendError(f"the autopilot's state is {vehicle.status.value}", field="pixhawk",
                           given=f"age {vehicle.age(now):.3f} s", allowed="fresh")  # fmt: skip
    if servos.age > servo_patience:
        raise BackendError("the servos' angles are too old", field="servos", given=f"age {servos.age:.3f} s",
                           allowed=f"up to {servo_patience:g} s")  # fmt: skip
    seen, at = (vehicle, vehicle.position_time) if pose is None else (pose, pose.time)
    quaternion, turned_at = (
        (vehicle.quaternion, vehicle.attitude_time) if pose is None else (pose.quaternion, pose.time)
    )
    window = 0.0 if config.mocap is None else config.mocap.velocity_window
    body_rates = vehicle.body_rates
    if pose is not None and vehicle.attitude_time < pose.time - window:
        body_rates = pose.body_rates
    carried = config.servos.stale_after  # the bus stops an arm that it does not hear for longer
    ahead = np.clip(now - servos.times[:n_arm], 0.0, carried)
    return Measurement(
        time=now - opened,
        position=seen.position,
        velocity=seen.velocity,
        attitude=_turned(quaternion, body_rates, at - turned_at),
        body_rates=body_rates,
        arm_angles=servos.angles[:n_arm] + ahead * servos.rates[:n_arm],
        arm_rates=servos.rates[:n_arm],
        pose_time=at - opened,
        tip_force=tip_force,
        leaf=leaf,
        frame=frame,
    )


def _turned(quaternion: Array, body_rates: Array, ahead: float) -> Array:
    turn = 0.5 * ahead * body_rates
    turned = np.array(multiply(quaternion.tolist(), [1.0, *turn.tolist()]))
    return np.array(to_attitude((turned / np.linalg.norm(turned)).tolist()))
