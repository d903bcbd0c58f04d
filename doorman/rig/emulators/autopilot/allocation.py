r"""PX4's control allocation, as far as forces to the side go: by rotors that its parameters CA_ROTORi place and tilt.

The pseudo-inverse of what the rotors do, each of its columns divided by the mean of its entries that are not zero, turns
normalised thrust into the rotors' shares of their thrust. Source: PX4, `ControlAllocationPseudoInverse.cpp`.
"""

from __future__ import annotations

import numpy as np

from doorman.rig.emulators.autopilot.parameters import ParameterStore
from doorman.rig.emulators.autopilot.plant import Array

_NOTHING = 1e-6
"""Entry of the pseudo-inverse that counts as zero."""
_FLIP = np.array([1.0, -1.0, -1.0])
"""The parameters are in x forward, y right, z down."""


def add_rotors(parameters: ParameterStore, positions: Array, axes: Array, moments: Array) -> None:
    """Be set up for rotors.

    Args:
        parameters: To which their parameters are added.
        positions: In the body, z up, shape (m, 3) [m].
        axes: Unit vectors of the thrusts, in the body, z up, shape (m, 3).
        moments: Drag by thrust, positive of counter-clockwise rotors, shape (m,) [m].
    """
    parameters.add("CA_ROTOR_COUNT", len(positions), whole=True)
    for i, (position, axis, moment) in enumerate(zip(positions * _FLIP, axes * _FLIP, moments, strict=True)):
        for letter, p, a in zip("XYZ", position, axis, strict=True):
            parameters.add(f"CA_ROTOR{i}_P{letter}", float(p))
            parameters.add(f"CA_ROTOR{i}_A{letter}", float(a))
        parameters.add(f"CA_ROTOR{i}_KM", float(moment))


def side_force(parameters: ParameterStore, share: tuple[float, float], full: float) -> tuple[float, float]:
    """Force along the body's x and y axis, z up, that normalised thrust along them becomes [N].

    Args:
        parameters: Of the autopilot; without rotors among them, it makes none.
        share: Normalised thrust, -1 … 1.
        full: Thrust along z of all rotors at their most [N].
    """
    if not any(share) or "CA_ROTOR_COUNT" not in parameters:
        return 0.0, 0.0
    rows = range(int(parameters["CA_ROTOR_COUNT"]))
    axes = np.array([[parameters[f"CA_ROTOR{i}_A{letter}"] for letter in "XYZ"] for i in rows]) * _FLIP
    places = np.array([[parameters[f"CA_ROTOR{i}_P{letter}"] for letter in "XYZ"] for i in rows]) * _FLIP
    moments = np.array([parameters[f"CA_ROTOR{i}_KM"] for i in rows])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    wrench = np.vstack([axes.T, (np.cross(places, axes) - moments[:, None] * axes).T])
    mix = np.linalg.pinv(wrench)[:, :2]
    rotors = np.zeros(len(axes))
    for column, each in zip(mix.T, share, strict=True):
        acting = np.abs(column[np.abs(column) > _NOTHING])
        rotors += column / acting.mean() * each if acting.size else 0.0
    x, y, _ = full / axes[:, 2].sum() * (rotors @ axes)
    return float(x), float(y)
