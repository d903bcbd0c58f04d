r"""Gusts: wind on vehicle and leaf, a force that varies by chance and whose direction turns and jumps.

.. math::
    F(t) = s\,\bar F\,(1 + v\,\xi(t)), \qquad
    d\xi = -\frac{\xi}{T}\,dt + \sqrt{\frac{2}{T}}\,dW, \qquad
    d(t) = d_0 + \omega t + j

ξ is an Ornstein-Uhlenbeck process of mean 0 and deviation 1, one for the vehicle and one for the leaf, v the `variation` and
T the `correlation_time`. A third one is the vertical force on the vehicle, of deviation `vertical`.

The wind blows towards d, with the `direction` d₀ and the `turn_rate` ω: of constant strength where v is
0. At random times the direction jumps by `jump_angle` to either side, which j sums. The strength s is then drawn anew, evenly
within `jump_strength` of 1. On the leaf the force acts at half its width w: the torque in the hinge is
:math:`\frac{w}{2} F \sin(d - \beta)` for a leaf along β, which is α where the door stands as its URDF has it.

A draught blows through the doorway along the closed leaf's normal. At the opening o its gap is open by the share
:math:`q = \min(1, 2\sin(o/2))`, the width of the gap over that of the leaf. The vehicle feels q of its force. The leaf feels
1 − q of it, along its normal, as the pressures on its sides even out.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.kinematics.doors.door import Door
from doorman.scenario import GustSection
from doorman.simulation.chance import Jumps
from doorman.simulation.simulator import Disturbance

_GUSTS = 2
"""Stream of random numbers of a seed for gusts."""
_JUMPS = 5
"""The stream that makes its jumps."""
_UPWARDS = 8
"""The stream that makes its vertical force."""


class Gust:
    """Wind of one flight."""

    def __init__(self, section: GustSection, door: Door, seed: int) -> None:
        self._section = section
        self._door, self._lever = door, door.lever_length(door.width / 2)
        self._generator = np.random.default_rng([seed, _GUSTS])
        self._upwards = np.random.default_rng([seed, _UPWARDS])
        self._variation, self._rises = self._generator.standard_normal(2).tolist(), self._rise()
        self._time, self._elapsed, self._kept, self._fresh = 0.0, 0.0, 1.0, 0.0
        self._jumps = Jumps(section.jump_rate, (seed, _JUMPS))
        self._jumped, self._strength = 0.0, 1.0
        self._through = door.normal(0.5 * math.pi)

    def at(self, time: float, door_angle: float) -> Disturbance:
        """Force and torque at one time."""
        wind = self._section
        self._vary(time)
        self._jump(time)
        of_vehicle, of_leaf = self._variation
        vehicle = (1.0 + wind.variation * of_vehicle) * (self._strength * wind.vehicle)
        leaf = (1.0 + wind.variation * of_leaf) * (self._strength * wind.leaf)
        towards = wind.direction + wind.turn_rate * time + self._jumped
        x, y = math.cos(towards), math.sin(towards)
        across, along, _ = self._door.normal(door_angle).tolist()
        blown = Disturbance(
            force=(vehicle * x, vehicle * y, wind.vertical * self._rises),
            hinge_torque=-self._lever * leaf * (across * x + along * y),
        )
        return together(blown, self._draught(door_angle)) if wind.draughty else blown

    def _draught(self, door_angle: float) -> Disturbance:
        """What blows through the gap, and presses on the leaf while there is none."""
        wind, opening = self._section, self._door.opening_of(door_angle)
        share = min(1.0, 2.0 * math.sin(0.5 * min(max(opening, 0.0), 0.5 * math.pi)))
        x, y, _ = (share * wind.draught * self._through).tolist()
        return Disturbance(force=(x, y, 0.0), hinge_torque=-self._lever * (1.0 - share) * wind.draught)

    def _jump(self, time: float) -> None:
        """Let the wind jump as often as it does in the time that has passed."""
        wind, generator = self._section, self._jumps.generator
        for _ in range(self._jumps.since(time)):
            self._jumped += wind.jump_angle * float(generator.choice([-1.0, 1.0]))
            self._strength = 1.0 + wind.jump_strength * float(generator.uniform(-1.0, 1.0))

    def _vary(self, time: float) -> None:
        """Advance ξ by the exact solution over the time that has passed."""
        elapsed, self._time = time - self._time, time
        if elapsed != self._elapsed:
            kept = math.exp(-elapsed / self._section.correlation_time)
            self._elapsed, self._kept, self._fresh = elapsed, kept, math.sqrt(1.0 - kept * kept)
        if self._kept < 1.0:
            kept, fresh, (vehicle, leaf) = self._kept, self._fresh, self._variation
            a, b = self._generator.standard_normal(2).tolist()
            self._variation = [kept * vehicle + fresh * a, kept * leaf + fresh * b]
            self._rises = kept * self._rises + fresh * self._rise()

    def _rise(self) -> float:
        """A standard normal number, where there is a vertical force."""
        return float(self._upwards.standard_normal()) if self._section.vertical > 0.0 else 0.0


def together(one: Disturbance, other: Disturbance) -> Disturbance:
    """Sum of two disturbances."""
    return Disturbance(
        force=_sum(one.force, other.force),
        torque=_sum(one.torque, other.torque),
        hinge_torque=one.hinge_torque + other.hinge_torque,
    )


def _sum(one: tuple[float, float, float], other: tuple[float, float, float]) -> tuple[float, float, float]:
    return one[0] + other[0], one[1] + other[1], one[2] + other[2]
