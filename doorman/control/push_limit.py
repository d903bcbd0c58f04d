r"""What the rotors push with at the leaf is bounded, whatever was estimated or planned.

.. math::
    F = m g\,e_3 + d, \qquad d \leftarrow d \min(1, d_{max}/|d|)

bounds the rotors' force beyond the weight in every direction, since the leaf may stand elsewhere than is believed. An impact
adds the vehicle's momentum to it, which the speed of the touch bounds.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.signals import Command


def force_in_world(command: Command) -> Array:
    """Force of the rotors, shape (3,), world frame [N]."""
    return np.asarray(rotation_body_to_world(command.attitude) @ command.body_force)


def limited(command: Command, weight: float, most: float) -> Command:
    """The command, or the one with the same heading and the same way of the push, and no harder than allowed."""
    up = np.array([0.0, 0.0, weight])
    beyond = force_in_world(command) - up
    size = math.sqrt(beyond.dot(beyond))
    if size <= most:
        return command
    force = up + most / size * beyond
    if any(command.side_force):  # a vehicle with a level body keeps its attitude
        ahead, left, lift = (rotation_body_to_world(command.attitude).T @ force).tolist()
        return replace(command, thrust=lift, side_force=(ahead, left))
    x, y, z = force.tolist()
    yaw, thrust = float(command.attitude[2]), math.sqrt(x * x + y * y + z * z)
    ahead, aside = math.cos(yaw) * x + math.sin(yaw) * y, math.cos(yaw) * y - math.sin(yaw) * x
    attitude = np.array([-math.asin(aside / thrust), math.atan2(ahead, z), yaw])
    return replace(command, thrust=thrust, attitude=attitude)
