r"""Filter of the door: angle, rate and the hinge's parameters, from the tip where it touches and from the model where not.

States :math:`z = [\alpha, \dot\alpha, w, b, \tau_c, k, I_D, f_x, f_y]`. With the push F_n of the rotors and
:math:`I = I_D + m_A D_V^2` in contact, without a push and :math:`I = I_D` out of it,

.. math::

   I\ddot\alpha = -D_V F_n - b\dot\alpha - \tau_c\,\mathrm{sgn}\,\dot\alpha - k(\alpha - \alpha_0) \mp \tau_p - w
   - l_W n_D^T f - G(\alpha)

w is a torque that comes and goes (gusts, what the model leaves out): a first-order Markov process. f is the mean wind on the
leaf, whose lever :math:`l_W` is half of a hinged leaf's width. It would pass for friction or a closer but for how it changes
with the angle; it is expected to blow as the vehicle feels it before the touch. An extended Kalman filter measures the tip's
angle. A door that stands still says nothing of its parameters but that its friction suffices: they rest until it moves. Their
standard deviations are what the motion has taught; damping, friction and closer stay correlated where the door has only seen one
speed. A seal or a latch says nothing of them either: the first degrees of a leaf that comes loose under far more than the hinge
should resist with are left out.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.beliefs import Beliefs
from doorman.control.kernels.door_filter.memory import ANGLE, FRICTION, INERTIA, RATE, STATES, STIFFNESS, DoorMemory
from doorman.control.kernels.door_filter.step import advance_door, hinge_of, pass_leaf
from doorman.kinematics.doors.leaf.leaf_kernels import leaf_numbers
from doorman.model import Model
from doorman.signals import Measurement

Array = NDArray[np.float64]

_INERTIA_SHARES = (0.4, 2.5)
"""Of the URDF's, between which an inertia is believed: a hand that shakes the leaf can make it seem anything."""
_AJAR = 0.02
"""A leaf that begins farther open stands there by its friction [rad]."""


@dataclass(frozen=True)
class HingeEstimate:
    """Parameters of the hinge with their standard deviations, SI units."""

    damping: float
    friction: float
    stiffness: float
    inertia: float
    damping_deviation: float
    friction_deviation: float
    stiffness_deviation: float
    inertia_deviation: float
    torque_deviation: float
    """Of friction and closer together at the present angle [N m]."""
    closing_wind: float = 0.0
    """Torque of the mean wind on the leaf at the present angle, positive where it closes the door [N m]."""
    spare: float = 0.0
    """Friction less closer, preload included, at the present angle: the door stays by itself where it is positive [N m]."""
    spare_deviation: float = 0.0
    """Its standard deviation [N m]."""


def _named(value: float, prior: tuple[float, float]) -> tuple[float, float]:
    """Mean and deviation of a prior; what the scenario names is expected."""
    return (value, prior[1]) if value > 0.0 else prior


class DoorFilter:
    """Estimate of the door's state and parameters.

    Args:
        model: Model of the scenario.
        settings: Prior and noise.
    """

    def __init__(self, model: Model, settings: Beliefs) -> None:
        start, lever = model.start_angle, model.coupling.lever_length
        self._door = door = model.door
        inertia = door.inertia
        prior = (
            (start, settings.angle_deviation), (0.0, 0.01), (0.0, settings.torque_deviation),
            _named(door.damping, settings.damping), _named(door.friction, settings.friction),
            _named(door.stiffness, settings.stiffness), (inertia, settings.inertia_deviation * inertia),
            (0.0, settings.leaf_wind_deviation), (0.0, settings.leaf_wind_deviation),
        )  # fmt: skip
        noises = settings.push_noise, settings.torque_deviation
        numbers = [
            lever, model.vehicle.mass * lever**2, door.rest_angle, door.closing_torque,
            *(share * inertia for share in _INERTIA_SHARES), settings.torque_time, settings.angle_noise,
            settings.push_noise_in_wind, settings.torque_deviation_in_wind, *settings.leaf_wind, settings.leaf_wind_share,
            door.wind_lever, -1.0 if door.side == "push" else 1.0, door.lower_limit, door.stop,
        ]  # fmt: skip
        self.memory = DoorMemory(
            numbers=np.array(numbers),
            leaf=leaf_numbers(door),
            memory=np.array([-math.inf, 0.0, *noises, 1.0, -math.inf]),
            state=np.array([mean for mean, _ in prior]),
            covariance=np.diag([deviation**2 for _, deviation in prior]),
            work=np.zeros((2, STATES)),
            hinge=np.zeros(len(fields(HingeEstimate))),
        )
        """What its kernels read and write."""
        self._past: deque[tuple[float, float]] = deque()
        self._seen = -math.inf
        if door.opening_of(start) > door.per_angle * _AJAR:
            self.stays()

    @property
    def state(self) -> Array:
        """z, shape (9,), written to by every update."""
        return self.memory.state

    @property
    def covariance(self) -> Array:
        """Shape (9, 9), written to by every update."""
        return self.memory.covariance

    @property
    def angle(self) -> float:
        """α [rad]."""
        return float(self.state[ANGLE])

    @property
    def angle_deviation(self) -> float:
        """Standard deviation of α [rad]."""
        return math.sqrt(max(float(self.covariance[ANGLE, ANGLE]), 0.0))

    @property
    def rate(self) -> float:
        """Rate α̇ of the door [rad/s]."""
        return float(self.state[RATE])

    @property
    def friction(self) -> float:
        """Friction τ_c [N m]."""
        return float(self.state[FRICTION])

    @property
    def stiffness(self) -> float:
        """Stiffness k of spring or closer [N m/rad]."""
        return float(self.state[STIFFNESS])

    @property
    def inertia(self) -> float:
        """I_D [kg m²]."""
        return float(self.state[INERTIA])

    def hinge(self) -> HingeEstimate:
        """Parameters with their standard deviations."""
        memory = self.memory
        hinge_of(memory.numbers, memory.leaf, memory.state, memory.covariance, memory.hinge)
        return self.known_hinge()

    def known_hinge(self) -> HingeEstimate:
        """The same, as a kernel has just found it."""
        return HingeEstimate(*self.memory.hinge.tolist())

    def update(
        self,
        push: float,
        touching: bool,
        tip_angle: float,
        measured_at: float,
        now: float,
        time_step: float,
        *,
        wind: Array | None = None,
    ) -> None:
        """Advance by one period."""
        if not time_step > 0.0:
            return
        wind_x, wind_y = (0.0, 0.0) if wind is None else (float(wind[0]), float(wind[1]))
        memory = self.memory
        advance_door(
            memory.numbers, memory.leaf, memory.memory, memory.state, memory.covariance, memory.work, push, touching,
            tip_angle, measured_at, now, time_step, wind_x, wind_y,
        )  # fmt: skip

    def see(self, angle: float, deviation: float, time: float, now: float) -> None:
        """Take in where a sensor has seen the leaf; what came late says by how much the angle of then was off."""
        self._past.append((now, self.angle))
        while len(self._past) > 1 and self._past[1][0] <= time:
            self._past.popleft()
        if time == self._seen:
            return
        self._seen = time
        state, covariance = self.state, self.covariance
        spread = covariance[:, ANGLE].copy()
        gain = spread / (spread[ANGLE] + deviation**2)
        off = angle - self._past[0][1]
        state += gain * off
        covariance -= np.outer(gain, spread)
        self._past = deque((at, past + float(gain[ANGLE]) * off) for at, past in self._past)

    def passed(self, tip_angle: float) -> None:
        """A leaf that is not touched is beyond the tip, wherever it was thought to be."""
        pass_leaf(self.memory.numbers, self.state, tip_angle)

    def meet(self, tip_angle: float) -> None:
        """The leaf stands where the tip is, wherever it was thought to be."""
        self.state[ANGLE], self.state[RATE] = tip_angle, 0.0

    def stays(self) -> None:
        """The leaf has stood here with nothing at it: friction is at least what the closer makes."""
        rest, known = self._door.rest_angle, self._door.closing_torque + self._door.weight_torque(self.angle)
        closer = abs(float(self.state[STIFFNESS] * (self.state[ANGLE] - rest))) + abs(known)
        self.state[FRICTION] = max(float(self.state[FRICTION]), 1.001 * closer)


def see_leaf(door: DoorFilter, model: Model, measured: Measurement) -> None:
    """Let a measured leaf correct what is believed of it."""
    if (leaf := measured.leaf) is not None:
        angle, deviation = model.door.angle_of_joint(leaf.joint), leaf.deviation / model.door.per_angle
        door.see(angle, deviation, leaf.time, measured.time)
