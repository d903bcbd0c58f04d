r"""Calibration: values of a vehicle file from what servos, cameras and a tape measure tell.

The vehicle stands level at P with heading ψ, and the cameras see the object at p with R:

.. math::
    p_O = R_z(\psi)^T (p - P), \qquad R_{BO} = R_z(\psi)^T R

The cameras' axes are turned about the vertical until the closed leaf points where the door's URDF has it. Then they are moved
until the hinge line's lower end is P_h.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import vector
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import ServoBus, ServoConfig, zero_position
from doorman.hardware.dynamixel.registers import DRIVE_MODE, HOMING_OFFSET
from doorman.hardware.mocap import MocapConfig, MocapReceiver
from doorman.hardware.vehicle.config import with_settings
from doorman.hardware.vehicle.waiting import LISTENING
from doorman.hardware.vehicle_file.file import MOCAP, NO_CAMERAS, OPTIONS, SERVOS, VehicleFile
from doorman.kinematics.doors.door import Door
from doorman.kinematics.quaternions import to_attitude
from doorman.kinematics.rotations import attitude_from_rotation, rotation_body_to_world

_SHIFTING = (HOMING_OFFSET.name, DRIVE_MODE.name)
"""Settings of a servo that shift or mirror its zero."""
LARGEST_DIFFERENCE = 0.02
"""Largest difference between the measured width of the leaf and the URDF's [m]."""


def servo_zeros(file: VehicleFile, angles: Sequence[float], device: str | None = None) -> dict[str, object]:
    """Zeros of the servos, whose joints are held at known angles with torque off."""
    own = _own(file, "servos", ("port", "zero_positions"))
    port = device or file.values.get(SERVOS)
    if port is None:
        raise BackendError(
            "the link's address or device is missing",
            file=file.path,
            field=SERVOS,
            allowed=f"in the file, or by {OPTIONS[SERVOS]}",
        )
    ids = own.pop("ids", tuple(range(1, len(angles) + 1)))
    if len(angles) != len(ids):
        raise BackendError("wrong number of angles", file=file.path, field="--posture", given=tuple(angles),
                           allowed=f"{len(ids)} angles, for servos {', '.join(map(str, ids))}")  # fmt: skip
    n = len(ids)
    config = with_settings(ServoConfig(port, [-math.pi] * n, [math.pi] * n, [1.0] * n, ids=ids), own, "servos.")
    bus = ServoBus(config)
    if wrong := [str(one) for one in bus.inspect() if one.register in _SHIFTING]:
        raise BackendError("; ".join(wrong), file=file.path, field="servos", allowed="settings that shift no zero")
    rows = zip(bus.positions(), angles, config.signs, strict=True)
    return {"servos.zero_positions": [zero_position(*row) for row in rows]}


def object_in_body(
    file: VehicleFile, position: ArrayLike, yaw: float, connection: str | None = None, duration: float = LISTENING
) -> dict[str, object]:
    """Where the tracked object is in the body, of a vehicle that stands level at a known place."""
    place = vector(position, 3, "position")
    own = _own(file, "mocap", ("connection", "object_position", "object_attitude"))
    link = connection or file.values.get(MOCAP)
    if link in (None, NO_CAMERAS):
        raise BackendError(
            "the vehicle has no cameras", file=file.path, field=MOCAP, given=link, allowed='such as "udp:51001"'
        )
    config = with_settings(MocapConfig(own.pop("object_name", "vehicle"), link), own, "mocap.")
    seen, rotation = _mean_pose(config, duration)
    back = rotation_body_to_world([0.0, 0.0, yaw]).T
    return {
        "mocap.object_position": _rounded(back @ (seen - place)),
        "mocap.object_attitude": _rounded(attitude_from_rotation(back @ rotation)),
    }


def _mean_pose(config: MocapConfig, duration: float) -> tuple[Array, Array]:
    positions, quaternions = [], []
    with MocapReceiver(config) as receiver:
        pose, end = receiver.read(), time.monotonic() + duration
        while time.monotonic() < end:
            pose = receiver.wait(pose, duration)
            if pose.fresh:
                positions.append(pose.position)
                quaternions.append(pose.quaternion)
    if len(positions) < 0.5 * duration * config.rate:
        raise BackendError("the cameras lose the object", field="mocap.object_name", given=config.object_name,
                           allowed=f"seen in most of {duration:g} s")  # fmt: skip
    motion = float(np.std(positions, axis=0).max())
    if motion > config.position_slack:  # what noise adds; else it does not stand still
        raise BackendError("the object moves", field="mocap.object_name", given=f"{motion * 1e3:.1f} mm",
                           allowed=f"up to {config.position_slack * 1e3:g} mm")  # fmt: skip
    turned = np.array(quaternions)
    mean = (turned * np.sign(turned @ turned[0])[:, None]).mean(axis=0)
    attitude = to_attitude((mean / np.linalg.norm(mean)).tolist())
    return np.mean(positions, axis=0), rotation_body_to_world(attitude)


def cameras_in_world(door: Door, hinge: ArrayLike, latch: ArrayLike) -> dict[str, object]:
    """Where the cameras' axes are in the world, from two points of the closed door."""
    near, far = vector(hinge, 3, "--hinge"), vector(latch, 3, "--latch")
    along = far - near
    width = math.hypot(along[0], along[1])
    if abs(width - door.width) > LARGEST_DIFFERENCE:
        raise BackendError("the distance between the points is not the leaf's width", field="--latch", given=f"{width:.3f} m",
                           allowed=f"{door.width:g} m ± {LARGEST_DIFFERENCE:g} m")  # fmt: skip
    there = door.leaf_direction(0.5 * math.pi)
    yaw = math.atan2(there[1], there[0]) - math.atan2(along[1], along[0])
    attitude = np.array([0.0, 0.0, math.remainder(yaw, 2.0 * math.pi)])
    return {
        "mocap.origin_position": _rounded(door.hinge_position - rotation_body_to_world(attitude) @ near),
        "mocap.origin_attitude": _rounded(attitude),
    }


def _own(file: VehicleFile, table: str, without: Sequence[str]) -> dict[str, Any]:
    """Values of a table by name of their key in it."""
    names = {key.partition(".")[2]: value for key, value in file.values.items() if key.startswith(f"{table}.")}
    return {name: value for name, value in names.items() if name not in without}


def _rounded(values: Array) -> list[float]:
    """Numbers to a hundredth of a millimetre or milliradian, without negative zeros."""
    return [round(float(value), 5) + 0.0 for value in values]
