r"""Gusts: wind on vehicle and leaf, a force that varies by chance and whose direction turns.

.. math::
    F(t) = \bar F\,(1 + v\,\xi(t)), \qquad
    d\xi = -\frac{\xi}{T}\,dt + \sqrt{\frac{2}{T}}\,dW, \qquad
    d(t) = d_0 + \omega t

ξ is an Ornstein-Uhlenbeck process of mean 0 and deviation 1, one for the vehicle and one for the leaf, v the `variation` and
T the `correlation_time`. The wind blows towards d, with the `direction` d₀ and the `turn_rate` ω: of constant strength where v is
0. On the leaf the force acts at half its width w: the torque in the hinge is :math:`\frac{w}{2} F \sin(d - \beta)` for a leaf
along β, which is α where the door stands as its URDF has it.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.kinematics.door import Door
from doorman.scenario import GustSection
from doorman.simulation.simulator import Disturbance

_GUSTS = 2
"""Of the random numbers of one seed, the stream that makes gusts."""


class Gust:
    """Wind of one flight.

    Args:
        section: Means, direction, its rate, and variation.
        door: The door, whose leaf it blows on.
        seed: Of the variation; the same seed gives the same wind to the bit.
    """

    def __init__(self, section: GustSection, door: Door, seed: int) -> None:
        self._section = section
        self._door, self._lever = door, door.width / 2
        self._generator = np.random.default_rng([seed, _GUSTS])
        self._variation = self._generator.standard_normal(2)
        self._time = 0.0

    def at(self, time: float, door_angle: float) -> Disturbance:
        """Force and torque at one time.

        Args:
            time: Not before that of the last call [s].
            door_angle: α [rad].

        Returns:
            Force on the vehicle and torque in the hinge.
        """
        wind = self._section
        self._vary(time)
        vehicle, leaf = (1.0 + wind.variation * self._variation) * (wind.vehicle, wind.leaf)
        towards = wind.direction + wind.turn_rate * time
        way = np.array([math.cos(towards), math.sin(towards), 0.0])
        return Disturbance(
            force=(vehicle * float(way[0]), vehicle * float(way[1]), 0.0),
            hinge_torque=-self._lever * leaf * float(self._door.normal(door_angle) @ way),
        )

    def _vary(self, time: float) -> None:
        """Advance ξ by the exact solution over the time that has passed."""
        kept = math.exp(-(time - self._time) / self._section.correlation_time)
        self._time = time
        if kept < 1.0:
            fresh = math.sqrt(1.0 - kept * kept)
            self._variation = kept * self._variation + fresh * self._generator.standard_normal(2)


def together(one: Disturbance, other: Disturbance) -> Disturbance:
    """Two disturbances at once."""
    return Disturbance(
        force=_sum(one.force, other.force),
        torque=_sum(one.torque, other.torque),
        hinge_torque=one.hinge_torque + other.hinge_torque,
    )


def _sum(one: tuple[float, float, float], other: tuple[float, float, float]) -> tuple[float, float, float]:
    return one[0] + other[0], one[1] + other[1], one[2] + other[2]
