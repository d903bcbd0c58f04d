"""Measuring thrust in flight: the normalised thrust that holds the vehicle, and how steeply thrust grows with it."""

from __future__ import annotations

from dataclasses import replace

from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.sequences import wait_for_sample
from doorman.hardware.pixhawk.setpoints import PositionSetpoint
from doorman.hardware.pixhawk.thrust.curve import HoverCalibration, ThrustCurve
from doorman.hardware.pixhawk.thrust.slope import BOB_TIME, Slope, SlopeMeasurement, bob

_BOB_PERIOD = 0.02
"""Between setpoints of a bob [s]."""


def measure_hover(link: Link, hover_force: float, duration: float, *, compensate_battery: bool) -> ThrustCurve:
    calibration, deadline = HoverCalibration(), link.time.now() + duration
    while (remaining := deadline - link.time.now()) > 0.0:
        wait_for_sample(link, calibration.add, remaining)
    old = link.stream.curve
    curve = calibration.curve(hover_force, 0.0 if old is None else old.shape, compensate_battery)
    if old is not None:
        curve = replace(
            old, hover_thrust=curve.hover_thrust, hover_force=hover_force, hover_voltage=curve.hover_voltage
        )
    link.stream.curve = curve
    return curve


def measure_slope(link: Link, at: PositionSetpoint) -> Slope | None:
    """Measure how steeply thrust grows with its setpoint, by bobbing up and aside a little; the vehicle must hold."""
    curve, measurement = link.stream.curve, SlopeMeasurement()
    begin = link.time.now()
    while (passed := link.time.now() - begin) < BOB_TIME:
        if not link.stream.offer(bob(at, passed), link.time.now()):
            return None
        wait_for_sample(link, measurement.add, _BOB_PERIOD)
    if not link.authority.hold(at, latch=False):
        return None
    return None if curve is None else measurement.slope(curve.hover_thrust)
