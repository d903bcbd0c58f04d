"""What is measured in hover before every mission: its thrust, how steeply thrust grows, and how late poses are."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.exceptions import BackendError
from doorman.hardware.mocap import PoseSample
from doorman.hardware.pixhawk import Autopilot, PositionSetpoint, VehicleSample
from doorman.hardware.pixhawk.thrust.slope import Slope, ThrustModel
from doorman.hardware.vehicle.waiting import SETTLING

_FOUND = 0.3
"""Largest deviation of a slope that is used: that of a push's thrust, twice over, stays below half of it."""
_LEAST_SLOPE, _MOST_SLOPE = 0.6, 2.6
"""Beyond 1, of motors that the autopilot linearises, and 2, of a signal that is squared, with what a battery that sags adds."""

STEEPEST = math.sqrt(2)
"""Slope, or one over it, up to which a tip that is not tied may press on the leaf: the autopilot's own loops of roll and pitch
act so many times as strongly as they were tuned. 3 dB are half of the 6 dB of gain margin that such loops are tuned to keep; the
other half is the contact's."""


def measure_hover(
    autopilot: Autopilot,
    at: PositionSetpoint,
    say: Callable[[str], None],
    note: Callable[[dict[str, Any]], None],
    steepest: float = math.inf,
) -> str:
    """Calibrate newtons in hover: the autopilot's own parameters may be defaults. Returns why the vehicle is not flown on."""
    config = autopilot.config
    assert config.hover_force is not None, "called only where newtons are sent"
    say("measure the thrust in hover")
    autopilot.hold(at=at)
    given = config.thrust_curve
    compensated = given is not None and given.hover_voltage is not None
    try:
        curve = autopilot.calibrate_hover(config.hover_force, SETTLING, compensate_battery=compensated)
    except BackendError as error:
        return str(error)
    slope = autopilot.measure_slope(at)
    if reason := judge_slope(slope) or (judge_model(slope, autopilot.thrust_model, curve.hover_thrust, steepest)):
        return reason
    found = slope is not None and slope.deviation <= _FOUND
    if slope is not None and found:
        curve = autopilot.shape_thrust(slope.shape(curve.hover_thrust))
    steep = f"a slope of {slope.value:.2f}" if slope is not None and found else "the slope was not found"
    say(f"{config.hover_force:.1f} N take {curve.hover_thrust:.2f} of full thrust; {steep}")
    note(
        {
            "thrust": curve.hover_thrust, "force": curve.hover_force, "voltage": autopilot.state().battery.voltage,
            "shape": curve.shape, "slope": math.nan if slope is None else slope.value,
            "slope_deviation": math.nan if slope is None else slope.deviation,
        }
    )  # fmt: skip
    return ""


def judge_slope(slope: Slope | None) -> str:
    """Why a vehicle whose thrust grows so is not flown; nothing if it is."""
    if slope is None or slope.deviation > _FOUND:
        return ""
    if not _LEAST_SLOPE <= slope.value <= _MOST_SLOPE:
        return (
            f"thrust grows {slope.value:.2f} times as fast as its setpoint; allowed: {_LEAST_SLOPE:g} to {_MOST_SLOPE:g}; "
            "check the autopilot's thrust model (THR_MDL_FAC, MOT_THST_EXPO), propellers and battery"
        )
    return ""


def judge_model(slope: Slope | None, model: ThrustModel | None, hover_thrust: float, steepest: float = STEEPEST) -> str:
    """Why a vehicle is not flown to the leaf with this thrust model, where a slope up to `steepest` is; nothing if it is."""
    if slope is None or slope.deviation > _FOUND or 1.0 / steepest <= slope.value <= steepest:
        return ""
    measured = f"thrust grows {slope.value:.2f} times as fast as its setpoint"
    bounds = f"allowed for a push: {1.0 / steepest:.2f} to {steepest:.2f}"
    if model is None:
        return f"{measured}; {bounds}; set the autopilot's thrust model, and tune its rate loops anew"
    right = model.right_value(slope, hover_thrust)
    return (
        f"{measured}: the motors' curve is {right:.2f}, {model.name} is {model.value:.2f}; {bounds}; "
        f"set {model.name} to {right:.2f}, reboot the autopilot, and tune its rate loops anew"
    )


_STEP, _MOST = 0.002, 0.15
"""Resolution and largest size of a delay that is looked for, either way [s]."""
_LEAST_MOTION = 0.004
"""Standard deviation of roll and pitch below which no delay is found [rad]."""
_LEAST_LIKENESS = 0.8
"""Correlation below which cameras and autopilot are strangers."""
_ENOUGH_READINGS = 40


class PoseDelay:
    """Collects attitudes of cameras and autopilot, each with the time at which it was true as far as is known."""

    def __init__(self) -> None:
        self._seen: list[tuple[float, float, float]] = []
        self._felt: list[tuple[float, float, float]] = []

    def note(self, pose: PoseSample, state: VehicleSample) -> None:
        """Take in the newest of both; what it has seen before does not count."""
        pose = pose.origin or pose
        if pose.usable and (not self._seen or pose.time > self._seen[-1][0]):
            self._seen.append((pose.time, float(pose.attitude[0]), float(pose.attitude[1])))
        if math.isfinite(state.attitude_time) and (not self._felt or state.attitude_time > self._felt[-1][0]):
            self._felt.append((state.attitude_time, float(state.attitude[0]), float(state.attitude[1])))

    @property
    def delay(self) -> float:
        """By how much poses are later than their stamps say [s]; NaN where the vehicle did not move enough to tell."""
        if min(len(self._seen), len(self._felt)) < _ENOUGH_READINGS:
            return math.nan
        seen, felt = np.array(self._seen), np.array(self._felt)
        inside = (seen[:, 0] > felt[0, 0] + _MOST) & (seen[:, 0] < felt[-1, 0] - _MOST)
        times, angles = seen[inside, 0], seen[inside, 1:]
        if len(times) < _ENOUGH_READINGS or float(np.std(angles, axis=0).max()) < _LEAST_MOTION:
            return math.nan
        delays = np.arange(-_MOST, _MOST + 0.5 * _STEP, _STEP)
        likeness = [_alike(angles, _at(times - delay, felt)) for delay in delays]
        best = int(np.argmax(likeness))
        if likeness[best] < _LEAST_LIKENESS or best in (0, len(delays) - 1):
            return math.nan
        return float(delays[best])


def _at(times: Array, felt: Array) -> Array:
    return np.column_stack([np.interp(times, felt[:, 0], felt[:, axis]) for axis in (1, 2)])


def _alike(first: Array, second: Array) -> float:
    first, second = first - first.mean(axis=0), second - second.mean(axis=0)
    power = math.sqrt(float((first**2).sum() * (second**2).sum()))
    return float((first * second).sum()) / power if power > 0.0 else 0.0
