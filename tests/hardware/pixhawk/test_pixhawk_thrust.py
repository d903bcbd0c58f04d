"""Thrust curve and hover calibration."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import Battery, ThrustCurve, VehicleSample
from doorman.hardware.pixhawk.thrust.curve import hover_curve

curves = st.builds(
    ThrustCurve,
    hover_thrust=st.floats(0.1, 0.8),
    hover_force=st.floats(1.0, 200.0),
    shape=st.floats(0.0, 1.0),
    hover_voltage=st.none() | st.just(15.0),
    min_thrust=st.just(0.0),
)
voltages = st.floats(10.0, 17.0) | st.just(math.nan)


@given(curves)
def test_hover_force_gives_hover_thrust(curve):
    assert curve.normalised(curve.hover_force, 15.0) == pytest.approx(curve.hover_thrust)


@given(curves, st.floats(0.0, 1.0), voltages)
def test_force_and_normalised_thrust_are_inverse(curve, thrust, voltage):
    assert curve.normalised(curve.force(thrust, voltage), voltage) == pytest.approx(thrust, abs=1e-6)


@given(curves, st.floats(0.0, 100.0), st.floats(0.0, 100.0), voltages)
def test_more_force_never_gives_less_thrust(curve, a, b, voltage):
    low, high = sorted((a, b))
    assert curve.normalised(low, voltage) <= curve.normalised(high, voltage) + 1e-12


def test_a_lower_voltage_asks_for_more_only_where_it_is_to_be_compensated():
    plain, compensated = ThrustCurve(0.4, 30.0), ThrustCurve(0.4, 30.0, hover_voltage=16.0)
    assert plain.normalised(30.0, 14.0) == pytest.approx(0.4)
    assert compensated.normalised(30.0, 14.0) == pytest.approx(0.4 * (16.0 / 14.0) ** 2)


@pytest.mark.parametrize("voltage", [math.nan, 0.0, -3.0, 100.0])
def test_an_unknown_or_absurd_voltage_is_not_compensated(voltage):
    assert ThrustCurve(0.4, 30.0, hover_voltage=16.0).normalised(30.0, voltage) == pytest.approx(0.4)


def test_what_is_sent_is_cut_to_the_limits():
    curve = ThrustCurve(0.4, 30.0, min_thrust=0.05, max_thrust=0.8)
    assert curve.normalised(-5.0) == 0.05
    assert curve.normalised(1e6) == 0.8


@pytest.mark.parametrize(
    "values",
    [{"hover_thrust": 0.0}, {"hover_thrust": math.nan}, {"hover_force": 0.0}, {"shape": 1.5}, {"hover_voltage": 0.1},
     {"min_thrust": 0.9, "max_thrust": 0.5}, {"max_thrust": 0.3}],
)  # fmt: skip
def test_curves_that_cannot_be_are_refused(values):
    with pytest.raises(BackendError, match="thrust_curve"):
        ThrustCurve(**{"hover_thrust": 0.4, "hover_force": 30.0, **values})


def hovering(index: int, thrust: float = 0.42, voltage: float = 15.0) -> VehicleSample:
    zero = np.zeros(3)
    return VehicleSample(
        velocity=zero, attitude=zero, armed=True, thrust_target=thrust, thrust_target_time=float(index),
        battery=Battery(voltage=voltage),
    )  # fmt: skip


def test_calibration_takes_the_median_of_calm_readings():
    samples = [hovering(index, 0.42 if index != 7 else 0.9) for index in range(20)]
    curve = hover_curve(samples, 29.4, compensate_battery=True)
    assert (curve.hover_thrust, curve.hover_force, curve.hover_voltage) == (0.42, 29.4, 15.0)
    assert hover_curve(samples, 29.4).hover_voltage is None


@pytest.mark.parametrize(
    "change",
    [{"velocity": np.array([0.5, 0.0, 0.0])}, {"attitude": np.array([0.3, 0.0, 0.0])}, {"armed": False},
     {"thrust_target": math.nan}, {"thrust_target": 0.0}, {"thrust_target_time": 1.0}],
)  # fmt: skip
def test_readings_that_are_not_calm_or_come_twice_do_not_count(change):
    with pytest.raises(BackendError, match="too few"):
        hover_curve([replace(hovering(index), **change) for index in range(20)], 29.4)


def test_a_hover_that_drifts_is_told_with_its_speed_and_the_limit():
    with pytest.raises(BackendError) as caught:
        hover_curve([replace(hovering(index), velocity=np.array([0.19, 0.0, 0.0])) for index in range(20)], 29.4)
    assert "0.19 m/s" in str(caught.value.given) and "0.15 m/s" in str(caught.value.allowed)
    with pytest.raises(BackendError, match="no sample"):
        hover_curve([], 29.4)


def test_compensation_needs_a_voltage():
    with pytest.raises(BackendError, match="voltage"):
        hover_curve([hovering(index, voltage=math.nan) for index in range(20)], 29.4, compensate_battery=True)
