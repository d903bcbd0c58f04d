"""Tip and face in numbers: what a whole-body plan begins with, and what its contact makes of a state."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.kinematics.numbers import Numbers
from doorman.model import Model
from doorman.planning.whole_body.numbers import tilt_stiffness


def whole_body_state(
    position: Array,
    attitude: Array,
    velocity: Array,
    attitude_rates: Array,
    joint: float,
    joint_rate: float,
    arm: Array,
) -> Array:
    """A state of the problem."""
    return np.concatenate([position, attitude, velocity, attitude_rates, [joint, joint_rate], arm])


def contact_forces(numbers: Numbers, model: Model, states: Array) -> Array:
    """Force of the contact's spring; of a tip that grips negative where it pulls."""
    depths = depths_in_face(model, states[:, :3], states[:, 3:6], states[:, 12], states[:, 14:])
    pressed = 0.5 * (depths + np.sqrt(depths**2 + 4.0 * numbers.one("contact.smoothing") ** 2))
    tied = numbers.one("contact.tied")
    return np.asarray(numbers.one("contact.stiffness") * ((1.0 - tied) * pressed + tied * depths))


def depths_in_face(model: Model, positions: Array, attitudes: Array, door_angles: Array, arm_angles: Array) -> Array:
    r"""How deep the tip is in the face, :math:`\delta = n_D^T(P + R\,d - P_h) + o`, and the way of a slide, for many states."""
    door = model.door
    from_hinge = positions + model.coupling.tips(attitudes, arm_angles) - door.hinge_position
    return np.asarray(
        (door.normals(door_angles) * from_hinge).sum(axis=1) + door.contact_offset + door.way(door_angles)
    )


def turned_by(
    model: Model, rotation_body_to_world: Array, arm_angles: Array, force: Array, loop: AttitudeLoop | None = None
) -> Array:  # fmt: skip
    """Roll and pitch beside the commanded ones that a force of the tip makes, until an integrator takes it up."""
    lever = model.coupling.tips(np.zeros((1, 3)), arm_angles[None])[0]
    if not model.vehicle.bodies.balanced:
        lever = lever - model.vehicle.center_of_mass(arm_angles)
    (x, y, z), (ahead, left, up) = lever.tolist(), (rotation_body_to_world.T @ force).tolist()
    return np.asarray(np.array([z * left - y * up, x * up - z * ahead]) / tilt_stiffness(model, loop))


def tip_on_face(off: Array, normal: Array, along: Array, up: Array) -> tuple[float, Array]:
    """How deep a tip is in the face, and its place along leaf and hinge, from the contact point."""
    return float(normal @ off), np.array([along @ off, up @ off])


def depth_of(force: float, numbers: Numbers) -> float:
    r"""Depth at which the contact's spring makes a force.

    .. math::
        \delta = \sigma - \epsilon^2/\sigma,\qquad
        \sigma = \tfrac12\big(\lambda/k + \sqrt{(\lambda/k)^2 + 4 g \epsilon^2}\big)

    A plan begins where the spring makes the force that is estimated: a millimetre of noise would be newtons. A tip that is not
    tied, g = 0, makes none without a push.
    """
    wanted, rounded = force / numbers.one("contact.stiffness"), numbers.one("contact.smoothing") ** 2
    pressed = 0.5 * (wanted + math.sqrt(wanted**2 + 4.0 * numbers.one("contact.tied") * rounded))
    return pressed - rounded / pressed


def stick_place(place: Array, friction_force: Array, normal_force: float, numbers: Numbers) -> Array:
    """Where the tip sticks or is held, if it is at a place and friction or the gripper makes a force there."""
    tied = numbers.one("contact.tied")
    share = friction_force / max(numbers.one("contact.friction") * normal_force, 1e-6)
    share = share * min(1.0, _MOST_GRIP / max(float(np.hypot(*share)), 1e-12))
    given = numbers.one("contact.give") * share / math.sqrt(1.0 - float(share @ share))
    return np.asarray(place - (1.0 - tied) * given - tied * friction_force / numbers.one("contact.stiffness"))


_MOST_GRIP = 0.9
"""Share of what friction carries that a plan may begin with: nearer to 1, the tip would be far from where it sticks."""
