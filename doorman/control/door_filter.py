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
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.model import Model
from doorman.scenario import EstimationSection

Array = NDArray[np.float64]

ANGLE, RATE, TORQUE, DAMPING, FRICTION, STIFFNESS, INERTIA, WIND_X, WIND_Y = range(9)
_STATES = 9
_PARAMETERS = (DAMPING, FRICTION, STIFFNESS, INERTIA)
_MOVING = 0.02
"""Slower than this the door counts as standing [rad/s]."""
_LONGEST_STEP = 0.02
"""A longer period, of a controller that was held up, is followed in parts [s]."""
_STUCK_RATE = 8.0
"""Bandwidth with which a standing door's angle is followed [rad/s]."""
_STUCK_DEVIATIONS = (0.002, 0.01)
"""Of angle and rate that are followed so, where they do not lag [rad], [rad/s]."""
_INERTIA_SHARES = (0.4, 2.5)
"""Of the URDF's, between which an inertia is believed: a hand that shakes the leaf can make it seem anything."""
_AJAR = 0.02
"""A leaf that begins farther open stands there by its friction [rad]."""
_PAST_ITS_END = 0.05
"""A tip that is farther beyond the joint's range is beside the leaf, and not before it [rad]."""
_SEALED, _UNSEALED = 2.0, 0.05
"""A leaf that comes loose under more than its hinge should resist with, by so many deviations, is sealed or latched. For so far
what it resists with says nothing of the hinge [rad]."""
_FELT = 0.1
"""Wind that says where it comes from [N]."""


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

    def __init__(self, model: Model, settings: EstimationSection) -> None:
        self._settings = settings
        self._lever = model.coupling.lever_length
        self._vehicle_inertia = model.vehicle.mass * self._lever**2
        start = float(model.start_state[3])
        self._door, self._rest = model.door, model.door.rest_angle
        self._preload = model.door.closing_torque
        inertia = model.door.inertia
        self._inertias = (_INERTIA_SHARES[0] * inertia, _INERTIA_SHARES[1] * inertia)
        door = model.door
        prior = (
            (start, settings.angle_deviation), (0.0, 0.01), (0.0, settings.torque_deviation),
            _named(door.damping, settings.damping), _named(door.friction, settings.friction),
            _named(door.stiffness, settings.stiffness), (inertia, settings.inertia_deviation * inertia),
            (0.0, settings.leaf_wind_deviation), (0.0, settings.leaf_wind_deviation),
        )  # fmt: skip
        self.state = np.array([mean for mean, _ in prior])
        """z, shape (9,)."""
        self.covariance = np.diag([deviation**2 for _, deviation in prior])
        """Shape (9, 9)."""
        self._seen = -math.inf
        self._touched, self._stood, self._sealed = False, True, -math.inf
        self._push_noise, self._torque_deviation = settings.push_noise, settings.torque_deviation
        if door.opening_of(start) > door.per_angle * _AJAR:
            self.stays()

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
        """α̇ [rad/s]."""
        return float(self.state[RATE])

    @property
    def inertia(self) -> float:
        """I_D [kg m²]."""
        return float(self.state[INERTIA])

    def hinge(self) -> HingeEstimate:
        """Parameters with their standard deviations."""
        p = self.covariance
        turned, known = abs(self._rest - self.angle), abs(self._known())
        squares = p.item(FRICTION, FRICTION) + turned * turned * p.item(STIFFNESS, STIFFNESS)
        together = 2.0 * turned * p.item(FRICTION, STIFFNESS)
        torque, spare = (math.sqrt(max(squares + sign * together, 0.0)) for sign in (1.0, -1.0))
        b, c, k, inertia = (self.state.item(row) for row in _PARAMETERS)
        d = [math.sqrt(max(p.item(row, row), 0.0)) for row in _PARAMETERS]
        wind = (-1.0 if self._door.side == "push" else 1.0) * float(self._wind_lever() @ self.state[WIND_X:])
        return HingeEstimate(b, c, k, inertia, d[0], d[1], d[2], d[3], torque, wind, c - known - k * turned, spare)

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
        """Advance by one period.

        Args:
            push: F_n of the rotors, wind included [N].
            touching: Whether the tip is on the leaf.
            tip_angle: Angle of the tip about the hinge [rad].
            measured_at: When it was true [s].
            now: [s].
            time_step: Since the last call [s].
            wind: On the vehicle before the first touch, shape (3,), world frame [N]; still air if not given.
        """
        if not time_step > 0.0:
            return
        if touching and not self._touched:
            self._touched = True
            self._expect(np.zeros(2) if wind is None else wind[:2])
        if touching and abs(self.rate) < _MOVING:
            self._track(tip_angle, now - measured_at, time_step)
            return
        if not touching and self.rate == 0.0 and self._holds():
            return
        self._come_loose(push if touching else 0.0)
        self._predict(push if touching else 0.0, touching, time_step)
        if touching and measured_at > self._seen:
            self._correct(tip_angle, now - measured_at)
        self._seen = measured_at

    def passed(self, tip_angle: float) -> None:
        """A leaf that is not touched is beyond the tip, wherever it was thought to be.

        Args:
            tip_angle: Angle of the tip about the hinge [rad].
        """
        end = self._door.lower_limit
        if end - _PAST_ITS_END < tip_angle < self.state[ANGLE]:
            self.state[ANGLE] = max(tip_angle, end)
            self.state[RATE] = min(self.state[RATE], 0.0)

    def meet(self, tip_angle: float) -> None:
        """The leaf stands where the tip is, wherever it was thought to be.

        Args:
            tip_angle: Angle of the tip about the hinge [rad].
        """
        self.state[ANGLE], self.state[RATE] = tip_angle, 0.0

    def stays(self) -> None:
        """The leaf has stood here with nothing at it: friction is at least what the closer makes."""
        closer = abs(float(self.state[STIFFNESS] * (self.state[ANGLE] - self._rest))) + abs(self._known())
        self.state[FRICTION] = max(float(self.state[FRICTION]), 1.001 * closer)

    def _known(self) -> float:
        """Torque of closer and weight that the scenario names, in the sense of damping [N m]."""
        return self._preload + self._door.weight_torque(self.angle)

    def _wind_lever(self) -> Array:
        """Torque of wind on the leaf, in the sense of damping, for each newton of its components, shape (2,) [m]."""
        return self._door.wind_lever * self._door.normal(self.angle)[:2]

    def _expect(self, wind: Array) -> None:
        """Wind on the leaf, and gusts, as the wind on the vehicle makes them likely."""
        settings, strength = self._settings, float(np.linalg.norm(wind))
        self._push_noise += settings.push_noise_in_wind * strength
        self._torque_deviation += settings.torque_deviation_in_wind * strength
        self.covariance[TORQUE, TORQUE] = self._torque_deviation**2
        if strength > 0.0:
            typical, deviation = settings.leaf_wind
            mean = typical + settings.leaf_wind_share * (strength - typical)
            along = min(strength / _FELT, 1.0) / strength * wind
            self.state[WIND_X:] = mean * along
            self.covariance[WIND_X:, WIND_X:] += deviation**2 * np.outer(along, along)

    def _holds(self) -> bool:
        """Whether friction holds a free door that stands."""
        closer = abs(self.state[STIFFNESS] * (self.state[ANGLE] - self._rest)) + abs(self._known())
        return bool(self.state[FRICTION] > closer)

    def _stop(self) -> None:
        """A door that its closer or its weight presses shut goes no farther than closed."""
        if self._known() != 0.0 and self._door.opening_of(self.angle) < 0.0:
            self.state[ANGLE], self.state[RATE] = self._door.angle_of_opening(0.0), 0.0

    def _track(self, tip_angle: float, age: float, time_step: float) -> None:
        """A standing door: follow the tip, leave the parameters alone.

        Where the door comes loose, angle and rate lag behind, and as much as they lag they are uncertain together; to take
        the rate's lag for motion would make the leaf light. The tip's angle is that of `age` ago besides.
        """
        self._stood = True
        parts = math.ceil(time_step / _LONGEST_STEP)
        for _ in range(parts):
            off = tip_angle - self.state[ANGLE]
            self.state[ANGLE] += time_step / parts * (self.state[RATE] + 2.0 * _STUCK_RATE * off)
            self.state[RATE] += time_step / parts * _STUCK_RATE**2 * off
        lag, p = abs(off), self.covariance
        rate = np.array([2.0 * _STUCK_RATE * lag, 0.0, _STUCK_DEVIATIONS[1]])
        angle = np.array([lag, _STUCK_DEVIATIONS[0], 0.0]) + age * rate
        p[: RATE + 1, :] = p[:, : RATE + 1] = 0.0
        p[ANGLE, ANGLE], p[RATE, RATE] = angle @ angle, rate @ rate
        p[ANGLE, RATE] = p[RATE, ANGLE] = angle @ rate

    def _come_loose(self, push: float) -> None:
        """Notice a seal as the leaf begins to move, and its end."""
        if self._stood:
            self._stood, hinge = False, self.hinge()
            bears = abs(self._lever * push + self._known() + hinge.stiffness * (self.angle - self._rest))
            if bears > hinge.friction + _SEALED * hinge.friction_deviation + self._torque_deviation:
                self._sealed = self.angle
                self.covariance[TORQUE, TORQUE] = bears**2
        elif math.isfinite(self._sealed) and abs(self.angle - self._sealed) > _UNSEALED:
            self._sealed, self.state[TORQUE] = -math.inf, 0.0
            self.covariance[TORQUE, :] = self.covariance[:, TORQUE] = 0.0
            self.covariance[TORQUE, TORQUE] = self._torque_deviation**2

    def _predict(self, push: float, touching: bool, time_step: float) -> None:
        z, settings = self.state, self._settings
        inertia = z[INERTIA] + (self._vehicle_inertia if touching else 0.0)
        slip = math.tanh(z[RATE] / (0.5 * _MOVING))
        wind = self._wind_lever()
        torque = z[DAMPING] * z[RATE] + z[FRICTION] * slip + z[STIFFNESS] * (z[ANGLE] - self._rest) + z[TORQUE]
        torque += self._known() + float(wind @ z[WIND_X:])
        acceleration = -(self._lever * push + torque) / inertia
        change = np.eye(_STATES)
        change[ANGLE, RATE] = time_step
        change[RATE, ANGLE] = -time_step * z[STIFFNESS] / inertia
        stiff = z[FRICTION] * (1.0 - slip * slip) / (0.5 * _MOVING)
        change[RATE, RATE] = 1.0 - time_step * min((z[DAMPING] + stiff) / inertia, 0.5 / time_step)
        change[RATE, TORQUE] = -time_step / inertia
        change[RATE, DAMPING] = -time_step * z[RATE] / inertia
        change[RATE, FRICTION] = -time_step * slip / inertia
        change[RATE, STIFFNESS] = -time_step * (z[ANGLE] - self._rest) / inertia
        change[RATE, INERTIA] = -time_step * acceleration / inertia
        change[RATE, WIND_X:] = -time_step * wind / inertia
        fade = math.exp(-time_step / settings.torque_time)
        change[TORQUE, TORQUE] = fade
        z[ANGLE] += time_step * z[RATE]
        rate = z[RATE] + time_step * acceleration
        if not touching and self._holds() and (rate * z[RATE] <= 0.0 or abs(rate) < 0.5 * _MOVING):
            rate = 0.0  # friction stops a free door, it does not drive it back
        z[RATE] = rate
        self._stop()
        z[TORQUE] *= fade
        covariance = change @ self.covariance @ change.T
        covariance[RATE, RATE] += time_step * (self._push_noise * self._lever / inertia) ** 2
        covariance[TORQUE, TORQUE] += (1.0 - fade**2) * self._torque_deviation**2
        self.covariance = covariance

    def _correct(self, tip_angle: float, age: float) -> None:
        """Measure the angle as it was `age` ago."""
        row, noise = np.zeros(_STATES), self._settings.angle_noise**2
        row[ANGLE], row[RATE] = 1.0, -age
        spread = self.covariance @ row
        gain = spread / (row @ spread + noise)
        if math.isfinite(self._sealed):
            gain[TORQUE + 1 :] = 0.0
        self.state += gain * (tip_angle - row @ self.state)
        self.state[DAMPING:INERTIA] = np.maximum(self.state[DAMPING:INERTIA], 0.0)
        self.state[INERTIA] = min(max(self.state[INERTIA], self._inertias[0]), self._inertias[1])
        left = np.eye(_STATES) - np.outer(gain, row)  # Joseph's form: right for a gain that is not the best
        covariance = left @ self.covariance @ left.T + noise * np.outer(gain, gain)
        self.covariance = 0.5 * (covariance + covariance.T)
