r"""How steeply thrust grows with the normalised thrust in hover, from a vehicle that bobs.

.. math::
    v(t) = v_0 + a\,t + s\,g \int_0^t \Big( \frac{\tau(u - \delta)}{\tau_{hover}} - 1 \Big) du, \qquad
    s = \frac{\tau_{hover}}{f_{hover}} \frac{df}{d\tau}

with the vertical velocity v and the delay δ at which it fits best. The slope s is 1 where the autopilot linearises the motors,
and 2 where thrust is the signal squared. The shape k of a `ThrustCurve` follows from it:

.. math::
    s = \frac{2 k \tau + 1 - k}{k \tau + 1 - k} \;\Rightarrow\; k = \frac{s - 1}{s - 1 + \tau\,(2 - s)}

An autopilot that undoes a curve with its own k leaves the motors' slope over that of its curve, both at the motors' signal u.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.gravity import weight_of
from doorman.hardware.pixhawk.sample import VehicleSample
from doorman.hardware.pixhawk.setpoints import PositionSetpoint
from doorman.hardware.pixhawk.thrust.curve import signal

_HEIGHT, _ASIDE, _PERIOD = 0.04, 0.03, 1.2
"""Height, way aside, period of the bob: a tenth of the weight, 5° of tilt, slow enough for 20 messages a second [m], [m], [s]."""
_DELAYS = np.arange(-0.04, 0.2001, 0.01)
"""Delays of velocity behind thrust that are tried: motors, estimator and lines; late thrust readings seem to lead [s]."""
BOB_TIME = 2 * _PERIOD + float(_DELAYS[-1])
"""Two times up and down, and the delay between thrust and velocity [s]."""
_ENOUGH_READINGS = 20
_CORRELATED = 3.0
"""Factor on the least squares' deviation: errors of an estimator's neighbouring velocities are correlated."""


@dataclass(frozen=True)
class Slope:
    value: float  # s
    deviation: float  # standard deviation of s

    def shape(self, hover_thrust: float) -> float:
        """Shape k of the curve with this slope, 0 … 1."""
        s = min(max(self.value, 1.0), 2.0)
        return (s - 1.0) / (s - 1.0 + hover_thrust * (2.0 - s))


@dataclass(frozen=True)
class ThrustModel:
    """The parameter by which an autopilot undoes the motors' curve."""

    name: str  # `THR_MDL_FAC` or `MOT_THST_EXPO`
    value: float  # k of the autopilot, 0 … 1

    def right_value(self, slope: Slope, hover_thrust: float) -> float:
        """The k with which this slope would be 1: that of the motors themselves."""
        k = min(max(self.value, 0.0), 1.0)
        u = signal(hover_thrust, k)
        own = (2.0 * k * u + 1.0 - k) / (k * u + 1.0 - k)
        return Slope(slope.value * own, slope.deviation).shape(u)


def measured_slope(samples: Sequence[VehicleSample], hover_thrust: float) -> Slope | None:
    """Slope from thrusts and climb rates of a vehicle that bobs about its hover; None where there are too few readings."""
    thrusts = {one.thrust_target_time: one.thrust_target for one in samples if math.isfinite(one.thrust_target)}
    climbs = {one.position_time: float(one.velocity[2]) for one in samples if math.isfinite(one.velocity[2])}
    if min(len(thrusts), len(climbs)) < _ENOUGH_READINGS:
        return None
    given, seen = np.array(sorted(thrusts.items())), np.array(sorted(climbs.items()))
    inside = (seen[:, 0] > given[0, 0] + _DELAYS[-1]) & (seen[:, 0] < given[-1, 0] + _DELAYS[0])
    times, velocities = seen[inside, 0], seen[inside, 1]
    if len(times) < _ENOUGH_READINGS:
        return None
    excess = given[:, 1] / hover_thrust - 1.0
    gained = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(given[:, 0]) * (excess[1:] + excess[:-1]))])
    fits = [
        _fit(times, velocities, weight_of(1.0) * np.interp(times - delay, given[:, 0], gained)) for delay in _DELAYS
    ]
    _, value, deviation = min(fits)
    return Slope(value, _CORRELATED * deviation)


def bob(at: PositionSetpoint, passed: float) -> PositionSetpoint:
    """Setpoint of a vehicle that bobs: h (1 − cos ωt) above the hold, and as a share of that to the left."""
    rate, angle = 2.0 * math.pi / _PERIOD, 2.0 * math.pi * passed / _PERIOD
    way = np.array([-_ASIDE * math.sin(at.yaw), _ASIDE * math.cos(at.yaw), _HEIGHT])
    return PositionSetpoint(
        at.position + (1.0 - math.cos(angle)) * way,
        at.yaw,
        rate * math.sin(angle) * way,
        rate**2 * math.cos(angle) * way,
    )


def _fit(times: Array, velocities: Array, pushed: Array) -> tuple[float, float, float]:
    basis = np.column_stack([np.ones_like(times), times - times[0], pushed])
    factors, *_ = np.linalg.lstsq(basis, velocities, rcond=None)
    left = float(((velocities - basis @ factors) ** 2).sum()) / max(1, len(times) - 3)
    alone = pushed - basis[:, :2] @ np.linalg.lstsq(basis[:, :2], pushed, rcond=None)[0]
    moved = float((alone**2).sum())
    return left, float(factors[2]), math.sqrt(left / moved) if moved > 0.0 else math.inf
