"""Plain twins of what the estimators' kernels are made of, in Python's numbers."""

from __future__ import annotations

import math

import numpy as np

from doorman.control.estimation.beliefs import ContactThresholds
from doorman.control.kernels.wind_step import correct_wind, predict_wind
from doorman.dynamics.attitude_loop import USUAL_LAG
from doorman.kinematics.rotations import euler_rates
from doorman.model import Model

Array = np.ndarray

_LONGEST_STEP = 0.02
"""Of a longer period, as of a controller that was held up, so much counts as watched [s]."""
_NOISE_AT_FIRST = 0.3
"""Deviation of the force that is assumed before it has been seen [N]."""
_NOISE_TIME = 0.7
"""In which it is learnt [s]."""


class PlainMonitor:
    """Whether the tip presses on the leaf."""

    def __init__(self, settings: ContactThresholds) -> None:
        self._settings = settings
        self._for = 0.0
        self._variance = _NOISE_AT_FIRST**2
        self._expected = False
        self.touching = False
        """The contact state."""

    def listen(self, normal_force: float, time_step: float) -> None:
        """Take in one period of free flight: all of the force is noise."""
        self._variance += min(time_step / _NOISE_TIME, 1.0) * (normal_force**2 - self._variance)

    def update(self, normal_force: float, time_step: float, distance: float = math.inf) -> bool:
        """Take in one period."""
        settings = self._settings
        if self.touching:
            disagrees, needed = normal_force < settings.lost_below, settings.lost_after
        else:
            noise = math.sqrt(self._variance)
            certain = max(settings.certain_above, settings.certain_deviations * noise)
            if self._expected and distance < settings.arrived_within:
                certain = min(certain, max(settings.arrived_above, settings.arrived_deviations * noise))
            disagrees = normal_force > min(settings.touched_above, certain)
            needed = 0.0 if normal_force > certain else settings.touched_after
        lasted = min(time_step, _LONGEST_STEP)
        self._for = self._for + lasted if disagrees else max(0.0, self._for - lasted)
        if disagrees and self._for >= needed - 1e-9:
            self.declare(not self.touching)
        return self.touching

    def declare(self, touching: bool) -> None:
        """Set the state on other evidence."""
        self.touching, self._for, self._expected = touching, 0.0, False

    def expect(self) -> None:
        """Expect a touch where the leaf is believed to stand; what follows must bear that it comes a little later."""
        self.declare(False)
        self._expected = True


class PlainHinge:
    """Estimate of the unknown hinge torque; right only while the tip is tied to the leaf, or presses on it."""

    def __init__(self, model: Model, rate: float, limit: float, *, whole: bool = False) -> None:
        self.rate = rate
        self.limit = limit
        self._door = model.door
        self._damping, self._stiffness = (0.0, 0.0) if whole else (model.door.damping, model.door.stiffness)
        self._lever = model.coupling.lever_length
        self._vehicle_inertia = model.vehicle.mass * self._lever**2
        self._torque = 0.0
        self._rate: float | None = None
        self.estimate = 0.0
        """τ̂_d, in the sense of damping: α̈ gains −τ̂_d/I, so it is negative where it resists opening [N m]."""

    def update(self, door_angle: float, door_rate: float, push: float, inertia: float, time_step: float) -> float:
        """Advance by one period."""
        if self.rate == 0.0:
            return self.estimate
        door, whole = self._door, inertia + self._vehicle_inertia
        if self._rate is None:
            self._rate, self._torque = door_rate, self.estimate
        resistance = self._damping * door_rate + self._stiffness * (door_angle - door.rest_angle)
        resistance += door.weight_torque(door_angle)
        part = 1.0 - math.exp(-self.rate * time_step)
        self._torque += part * (-self._lever * push - resistance - self._torque)
        self._rate += part * (door_rate - self._rate)
        taken = whole * self.rate * (door_rate - self._rate)
        self.estimate = min(max(self._torque - taken, -self.limit), self.limit)
        self._torque = self.estimate + taken  # anti-windup: the state stays where the bound is
        return self.estimate

    def restart(self, estimate: float) -> None:
        """Go on from another estimate."""
        self.estimate = min(max(estimate, -self.limit), self.limit)
        self.pause()

    def pause(self) -> None:
        """Keep the estimate while the tip is away; the next update begins from the rate that it is given."""
        self._rate = None


LONGEST_LAG = 1.0
"""[s]."""
_WEIGHT = 0.02
"""Of that prior: mean square of the rates times their time [rad²/s]."""
_FORGETTING = 10.0
"""[s]."""


class PlainResponse:
    """Lag of roll and pitch, updated every tick."""

    def __init__(self, usual_lag: float = USUAL_LAG) -> None:
        self.lag = self._usual_lag = usual_lag
        """τ [s]."""
        self._moved = self._behind = 0.0

    def update(self, told: Array, attitude: Array, body_rates: Array, time_step: float) -> None:
        """Take in a tick."""
        roll, pitch = float(attitude[0]), float(attitude[1])
        roll_rate, pitch_rate, _ = euler_rates(attitude, body_rates)
        moved = roll_rate * roll_rate + pitch_rate * pitch_rate
        behind = roll_rate * (float(told[0]) - roll) + pitch_rate * (float(told[1]) - pitch)
        kept = math.exp(-time_step / _FORGETTING)
        self._moved = kept * self._moved + time_step * moved
        self._behind = kept * self._behind + time_step * behind
        lag = (self._behind + _WEIGHT * self._usual_lag) / (self._moved + _WEIGHT)
        self.lag = min(max(lag, 0.0), LONGEST_LAG)


_FIRST, _FIRST_TURN = 0.5, 0.1
"""Deviations at first of each part of the wind [N], and of its turning [rad/s]."""
_GUSTS, _TURNS = 0.06, 0.01
"""Growth of these in a second [N], [rad/s]."""
_FELT, _FELT_TIME = 0.12, 0.25
"""Noise of what the shipped vehicle feels, and the time after which it is another one [N], [s]."""
_NEAR_NOISE = 3.0
"""By so much less is believed what is felt near the leaf: it may be a touch."""
_BOUND, _BOUND_TIME = 0.3, 0.5
"""Noise of what contact can explain there, and the time after which it is another one [N], [s]."""
_SUDDEN, _JUMP = 0.5, 0.6
"""Noise of the wind where contact is found to be lost, or to be there, of the shipped vehicle [N]."""
_HINGE, _HINGE_CHANGES = (1.0, 1.5), 0.7
"""τ of a room door at first with its deviation [N m], and its change with the square root of the way [N m/rad^0.5]."""
_MOVED, _MOVED_TIME, _MOVES = 0.2, 0.8, 0.012
"""Noise of the torque that moves such a leaf, the time after which it is another one, and the rate of a leaf that moves [N m],"""
_SETTLES = 0.6
"""For so long the observer of the outer force settles after take-off [s]."""
_STEADY = 0.15
"""Weaker wind has no direction that turns [N]."""


_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class PlainWind:
    """Of one flight."""

    def __init__(self, force: float = 1.0, hinge: float = 1.0) -> None:
        self._force, self._hinge = force, hinge
        self.state = np.array([0.0, 0.0, 0.0, 0.0, hinge * _HINGE[0]])
        """[w, ω, τ], shape (5,) [N], [rad/s], [N m]."""
        self.covariance = np.diag([(force * _FIRST) ** 2] * 3 + [_FIRST_TURN**2, (hinge * _HINGE[1]) ** 2])
        """Shape (5, 5)."""
        self._flown = 0.0
        self.predict(0.0)  # compiles, as the next line does: nothing is in flight
        correct_wind(self.state, self.covariance, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)

    @property
    def force(self) -> Array:
        """w, shape (3,), world frame [N]."""
        return self.state[:3].copy()

    def predict(self, time_step: float) -> None:
        """Advance by one period."""
        self._flown += time_step
        steady, gusts = self._force * _STEADY, (self._force * _GUSTS) ** 2
        predict_wind(self.state, self.covariance, time_step, steady, gusts, _TURNS**2)

    def feel(self, felt: Array, near: bool, time_step: float) -> None:
        """Take in what is felt in free flight."""
        if self._flown < _SETTLES or time_step <= 0.0:
            return
        noise = (self._force * _FELT) ** 2 * (_NEAR_NOISE**2 if near else 1.0) * max(_FELT_TIME / time_step, 1.0)
        self._take_for_wind(felt, noise)

    def unexplained(self, direction: Array, force: float, time_step: float) -> None:
        """Take in a part of what the tip seems to feel that no contact makes."""
        if force != 0.0 and time_step > 0.0:
            self._correct(direction, -force, (self._force * _BOUND) ** 2 * max(_BOUND_TIME / time_step, 1.0))

    def pushed(
        self, normal: Array, levers: tuple[float, float], torque: float, opening: float, closer: float, time_step: float
    ) -> None:
        """Take in what the rotors turn the leaf with. One that stands bears that much, or more."""
        if time_step <= 0.0:
            return
        self.state[4] += closer * opening * time_step
        self.covariance[4, 4] += (self._hinge * _HINGE_CHANGES) ** 2 * abs(opening) * time_step
        lever, (x, y, up) = -sum(levers), normal.tolist()
        wind_x, wind_y, wind_up, _, hinge = self.state.tolist()
        off = torque - (lever * (x * wind_x + y * wind_y + up * wind_up) + hinge)
        if opening > _MOVES or off > 0.0:
            noise = (self._hinge * _MOVED) ** 2 * max(_MOVED_TIME / time_step, 1.0)
            correct_wind(self.state, self.covariance, lever * x, lever * y, lever * up, 1.0, off, noise)

    def pressed(self, normal: Array, force: float, noise: float, offset: float, time_step: float) -> None:
        """Take in the wind along the normal, as a sensor of the tip's force tells it."""
        if self._flown >= _SETTLES and time_step > 0.0:
            density = (self._force * _FELT) ** 2 * _FELT_TIME + (offset / (self._force * _GUSTS)) ** 2
            self._correct(normal, force - float(normal @ self.state[:3]), noise + density / time_step)

    def met(self, normal: Array, more: float) -> None:
        """Take in that the tip presses harder than the wind seemed to say."""
        self._correct(normal, more, (self._force * _SUDDEN) ** 2)

    def lost(self, felt: Array) -> None:
        """Take in that there is no contact: what is felt is wind."""
        for k in range(3):
            self.covariance[k, k] += (self._force * _JUMP) ** 2
        self._take_for_wind(felt, (self._force * _SUDDEN) ** 2)

    def _take_for_wind(self, felt: Array, noise: float) -> None:
        for k, (x, y, up) in enumerate(_AXES):
            correct_wind(self.state, self.covariance, x, y, up, 0.0, float(felt[k] - self.state[k]), noise)

    def _correct(self, direction: Array, off: float, noise: float) -> None:
        x, y, up = direction.tolist()
        correct_wind(self.state, self.covariance, x, y, up, 0.0, off, noise)
