r"""Mixer: where thrust and torque come from, and the mixer that shares a demand out among them.

An upright rotor i at :math:`(x_i, y_i)` with thrust :math:`f_i` and sense :math:`s_i`, +1 counter-clockwise seen from above,
makes

.. math::
    [f_t,\ \tau_x,\ \tau_y,\ \tau_z]^T = B f, \qquad B_i = [1,\ y_i,\ -x_i,\ -s_i\kappa]^T

with κ the ratio of drag torque to thrust. The mixer is :math:`f = B^+ [f_t, \tau]` where that is possible. Where it is not,
it gives up yaw first, then moves the thrust as little as roll and pitch need, and scales these only when no thrust is left
that carries them. Tilted rotors have their own columns (`RotorLayout.wrench`). Force to the side comes last.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.kinematics.vehicles.rotor_layout import RotorLayout


class MixerParameters(NamedTuple):
    """Numbers of the mixer kernel."""

    lift: Array  # thrust of every rotor for a thrust of 1, a column of B⁺, shape (m,), see `RotorLayout.inverse`
    roll: Array  # for a torque of 1 about x, shape (m,) [1/m]
    pitch: Array  # about y
    yaw: Array  # about z
    ahead: Array  # for a force of 1 along x, shape (m,)
    left: Array  # along y
    allocation: Array  # B, shape (4, m)
    max_thrusts: Array  # shape (m,) [N]
    thrusts: Array  # result: thrust set point of every rotor, shape (m,) [N]
    achieved: Array  # result: [f_t, τ] that these make, shape (4,)

    @classmethod
    def of(cls, layout: RotorLayout) -> MixerParameters:
        """Parameters of a rotor layout."""
        m = layout.count
        lift, roll, pitch, yaw = np.ascontiguousarray(layout.inverse.T)
        ahead, left = np.ascontiguousarray(layout.side_inverse.T)
        allocation = np.ascontiguousarray(layout.allocation)
        return cls(lift, roll, pitch, yaw, ahead, left, allocation, layout.max_thrusts.copy(), np.zeros(m), np.zeros(4))


@kernel
def tilt_scale(p: MixerParameters, roll_torque: float, pitch_torque: float) -> float:
    """Largest share of a roll and pitch torque that some thrust can carry with every rotor inside its limits."""
    scale = 1.0
    for i in range(p.thrusts.shape[0]):
        low = (p.roll[i] * roll_torque + p.pitch[i] * pitch_torque) / p.lift[i]
        for j in range(p.thrusts.shape[0]):
            high = (p.roll[j] * roll_torque + p.pitch[j] * pitch_torque) / p.lift[j]
            room = p.max_thrusts[j] / p.lift[j]
            if (high - low) * scale > room:
                scale = room / (high - low)
    return scale


@kernel
def mix(p: MixerParameters, thrust: float, torque: Array) -> None:
    """Share [f_t, τ] out among the rotors, into `p.thrusts`, inside [0, max], and `p.achieved`."""
    count = p.thrusts.shape[0]
    scale = tilt_scale(p, torque[0], torque[1])
    lowest, highest = -1e300, 1e300
    for i in range(count):
        tilt = scale * (p.roll[i] * torque[0] + p.pitch[i] * torque[1])
        p.thrusts[i] = tilt
        lowest = max(lowest, -tilt / p.lift[i])
        highest = min(highest, (p.max_thrusts[i] - tilt) / p.lift[i])
    lift = max(min(thrust, highest), lowest)
    share = 1.0
    for i in range(count):
        p.thrusts[i] += lift * p.lift[i]
        turn = p.yaw[i] * torque[2]
        if turn > 1e-12:
            share = min(share, max(p.max_thrusts[i] - p.thrusts[i], 0.0) / turn)
        elif turn < -1e-12:
            share = min(share, max(p.thrusts[i], 0.0) / -turn)
    p.achieved[:] = 0.0
    for i in range(count):
        f = min(max(p.thrusts[i] + share * p.yaw[i] * torque[2], 0.0), p.max_thrusts[i])
        p.thrusts[i] = f
        for k in range(4):
            p.achieved[k] += p.allocation[k, i] * f


@kernel
def add_side(p: MixerParameters, ahead: float, left: float) -> None:
    """Add the largest share of a force to the side that leaves every rotor inside [0, max], to `p.thrusts`."""
    share = 1.0
    for i in range(p.thrusts.shape[0]):
        more = p.ahead[i] * ahead + p.left[i] * left
        if more > 1e-12:
            share = min(share, (p.max_thrusts[i] - p.thrusts[i]) / more)
        elif more < -1e-12:
            share = min(share, p.thrusts[i] / -more)
    for i in range(p.thrusts.shape[0]):
        more = p.ahead[i] * ahead + p.left[i] * left
        p.thrusts[i] = min(max(p.thrusts[i] + share * more, 0.0), p.max_thrusts[i])
