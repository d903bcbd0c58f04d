r"""A measurement whose pose is old, carried on to now.

.. math::
    \Phi(t) = \Phi_0 + (t - t_0)\,W(\Phi_0)\,\Omega, \qquad p(t) = p_0 + (t - t_0)\,\hat v, \qquad H(t) = H_0 + (t - t_0)\,\dot H

with the body rates Ω, which the gyroscope tells without delay, and the observer's velocity.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from doorman.kinematics.rotations import euler_rates
from doorman.signals import Measurement

Array = NDArray[np.float64]


def present_attitude(measured: Measurement) -> Array:
    """Φ now, shape (3,) [rad]."""
    age = measured.time - measured.pose_time
    if age <= 0.0:
        return measured.attitude
    return np.asarray(measured.attitude + age * np.array(euler_rates(measured.attitude, measured.body_rates)))


def present_posture(measured: Measurement) -> tuple[Array, Array]:
    """Φ and H now, shapes (3,) and (n,) [rad]."""
    age = 0.0 if measured.arm_time is None else measured.time - measured.arm_time
    arm = measured.arm_angles + age * measured.arm_rates if age > 0.0 else measured.arm_angles
    return present_attitude(measured), arm


def present(measured: Measurement, velocity: Array) -> Measurement:
    """The measurement with position, attitude and joint angles of now."""
    age = measured.time - measured.pose_time
    arm_age = 0.0 if measured.arm_time is None else measured.time - measured.arm_time
    if age <= 0.0 and arm_age <= 0.0:
        return measured
    return replace(
        measured, position=measured.position + age * velocity, attitude=present_attitude(measured),
        arm_angles=measured.arm_angles + arm_age * measured.arm_rates, pose_time=measured.time, arm_time=None,
    )  # fmt: skip
