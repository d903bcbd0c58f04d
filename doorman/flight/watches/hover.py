"""Thrust in hover, measured before every mission: how much of the full thrust holds the vehicle, and how steeply it grows."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import Autopilot, PositionSetpoint
from doorman.hardware.pixhawk.thrust.slope import Slope, ThrustModel

_HOVER_TIME = 2.0
"""For which the thrust in hover is measured [s]."""
_FOUND = 0.3
"""Largest deviation of a slope that is used: that of a push's thrust, twice over, stays below half of it."""
_LEAST_SLOPE, _MOST_SLOPE = 0.6, 2.6
"""Beyond 1, of motors that the autopilot linearises, and 2, of a signal that is squared, with what a battery that sags adds."""

STEEPEST = math.sqrt(2.0)
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
        curve = autopilot.calibrate_hover(config.hover_force, _HOVER_TIME, compensate_battery=compensated)
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
