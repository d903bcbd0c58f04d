r"""What mixer and motors make of the normalised thrust that an emulated autopilot asks for.

.. math::
    \tau = k u^2 + (1 - k)\,u, \qquad \frac{f}{f_{max}} = u^2

for the signal u of motors whose thrust is its square, as that of propellers is, and with k of PX4's `THR_MDL_FAC` or
ArduPilot's `MOT_THST_EXPO`. At k = 0 the autopilot takes the signal for the thrust, at k = 1 it linearises the motors.

PX4 makes forces to the side by rotors that its parameters CA_ROTORi place and tilt: the pseudo-inverse of what the rotors do,
each of its columns divided by the mean of its entries that are not zero, turns normalised thrust into the rotors' shares.
Sources: PX4, parameter reference and `ControlAllocationPseudoInverse.cpp`; ArduPilot,
`AP_MotorsMulticopter::apply_thrust_curve_and_volt_scaling`.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from doorman.arrays import Array
from doorman.rig.emulators.autopilot.parameters import ParameterStore
from doorman.rig.emulators.autopilot.vehicle.plant import FLIP

MotorKind = Literal["linear", "quadratic"]
"""Motors that the autopilot's parameter linearises; or with the factory's parameter."""
_NOTHING = 1e-6
"""Entry of the pseudo-inverse that counts as zero."""


def thrust_share(normalised: float, k: float) -> float:
    """f/f_max = u² of motors whose thrust is the signal squared."""
    if k < 1e-6:
        return normalised * normalised
    u = (math.sqrt((1.0 - k) ** 2 + 4.0 * k * normalised) - (1.0 - k)) / (2.0 * k)
    return u * u


def normalised_thrust(share: float, k: float) -> float:
    """τ of a share of the largest thrust, the inverse of `thrust_share`."""
    return k * share + (1.0 - k) * math.sqrt(share)


def add_rotors(parameters: ParameterStore, positions: Array, axes: Array, moments: Array) -> None:
    """Be set up for rotors."""
    parameters.add("CA_ROTOR_COUNT", len(positions), whole=True)
    rows = np.column_stack([positions * FLIP, axes * FLIP, moments])
    for i, row in enumerate(rows.tolist()):
        for name, value in zip(("PX", "PY", "PZ", "AX", "AY", "AZ", "KM"), row, strict=True):
            parameters.add(f"CA_ROTOR{i}_{name}", value)


def side_force(parameters: ParameterStore, share: tuple[float, float], full: float) -> tuple[float, float]:
    """Force along the body's x and y axis, z up, that normalised thrust along them becomes [N]."""
    if not any(share) or "CA_ROTOR_COUNT" not in parameters:
        return 0.0, 0.0
    rotors = [f"CA_ROTOR{i}_" for i in range(int(parameters["CA_ROTOR_COUNT"]))]
    places, axes = (np.array([[parameters[r + kind + x] for x in "XYZ"] for r in rotors]) * FLIP for kind in "PA")
    moments = np.array([parameters[r + "KM"] for r in rotors])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    wrench = np.vstack([axes.T, (np.cross(places, axes) - moments[:, None] * axes).T])
    signals = np.zeros(len(axes))
    for column, each in zip(np.linalg.pinv(wrench)[:, :2].T, share, strict=True):
        acting = np.abs(column[np.abs(column) > _NOTHING])
        signals += column / acting.mean() * each if acting.size else 0.0
    x, y, _ = full / axes[:, 2].sum() * (signals @ axes)
    return float(x), float(y)
