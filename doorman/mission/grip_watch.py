"""Whether a gripper that was told to close holds the leaf: what a loose tip is pushed and pulled with, no leaf takes."""

from __future__ import annotations

import math

import numpy as np

from doorman.control.estimator import Estimate
from doorman.model import GRAVITY, Model

TUG = 0.05
"""Share of the weight with which a gripper is tried that has just closed;"""
_MOVES = 0.015
"""of a change of push or pull from which on the tip's force is looked at."""
_STEADY = 1.0
"""What is steady over so long a time is left out of both [s]: of a pull that brakes an opening door friction may take all."""
_WINDOW = 0.3
"""Time over which both are averaged, by their squares [s]."""
_FELT = 0.25
"""Share of the push that leaf and hinge take at least: a leaf of 3 kg that nothing holds takes half of it."""
_SURELY = 0.12
"""For which it must have been less [s]."""


class GripWatch:
    r"""Feels whether the gripper holds, wherever the vehicle pushes or pulls.

    Of a change of its push, a vehicle whose tip holds the leaf feels the change of
    :math:`\lambda_n = \frac{I_D}{I_e}F_n - \frac{m_A D_V}{I_e}\tau`, a loose one nothing. The push is delayed as the estimated
    force is, by the three poles of the vehicle's observer.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        self._least = (_MOVES * model.vehicle.mass * GRAVITY) ** 2
        self._rate = model.scenario.estimation.vehicle_observer_rate
        self._poles = np.zeros(3)
        self._begin()

    def _begin(self) -> None:
        self._steady, self._squares, self._loose_for = np.zeros(2), np.zeros(2), 0.0

    def is_loose(self, estimate: Estimate, holds: bool, time_step: float) -> bool:
        """Take in what is known now; once per tick.

        Args:
            estimate: It.
            holds: Whether the gripper has been told to hold, and has had time to.
            time_step: Since the last call [s].

        Returns:
            Whether the vehicle has pushed or pulled for long enough and felt no leaf.
        """
        push = estimate.push
        for pole in range(3):
            self._poles[pole] += _share(self._rate * time_step) * (push - self._poles[pole])
            push = self._poles[pole]
        if not holds:
            self._begin()
            return False
        both = np.array([push, estimate.normal_force])
        self._steady += _share(time_step / _STEADY) * (both - self._steady)
        self._squares += _share(time_step / _WINDOW) * ((both - self._steady) ** 2 - self._squares)
        pushed, felt = self._squares
        loose = pushed > self._least and felt < _FELT**2 * pushed
        self._loose_for = self._loose_for + time_step if loose else 0.0
        return self._loose_for > _SURELY


def _share(steps: float) -> float:
    """Share that a low-pass takes over in so many of its time constants."""
    return 1.0 - math.exp(-steps)
