"""Slope of the thrust in hover: what a bob tells of it, and that of motors whose thrust is the signal squared."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pixhawk_rig import WEIGHT

from doorman.flight.hover import STEEPEST, judge_model, judge_slope, measure_hover
from doorman.gravity import GRAVITY
from doorman.hardware.pixhawk import AttitudeSetpoint, PositionSetpoint, ThrustCurve, VehicleSample
from doorman.hardware.pixhawk.thrust.slope import BOB_TIME, Slope, ThrustModel, bob, measured_slope
from doorman.rig.emulators.autopilot.control import thrust_share

AT = PositionSetpoint(np.array([-1.0, 0.5, 1.2]), 0.3)


def test_a_bob_is_a_motion_that_begins_and_ends_where_it_holds():
    step, times = 1e-4, np.linspace(0.0, BOB_TIME, 40)
    for time in times:
        before, now, after = (bob(AT, time + shift) for shift in (-step, 0.0, step))
        assert np.allclose((after.position - before.position) / (2 * step), now.velocity, atol=1e-5)
        assert np.allclose((after.velocity - before.velocity) / (2 * step), now.acceleration, atol=1e-4)
        assert np.linalg.norm(now.position - AT.position) < 0.12 and np.linalg.norm(now.velocity) < 0.4
    assert np.allclose(bob(AT, 0.0).position, AT.position) and np.allclose(
        bob(AT, 2.4).position, AT.position, atol=1e-9
    )


@given(st.floats(1.0, 2.0), st.floats(0.1, 0.9))
def test_the_shape_is_that_of_the_curve_with_this_slope(slope, hover):
    curve = ThrustCurve(hover, 30.0, Slope(slope, 0.0).shape(hover), max_thrust=1.0)
    steep = (curve.force(hover + 1e-6) - curve.force(hover - 1e-6)) / 2e-6
    assert steep * hover / 30.0 == pytest.approx(slope, rel=1e-5)


def measured(slope: float, hover: float, delay: float, noise: float, bias: float = 0.0) -> Slope:
    """Of a vehicle that bobs so, heard at 20 and 50 messages a second."""
    random, samples, rate = np.random.default_rng(3), [], 2.0 * math.pi / 1.2
    for index in range(round(100 * BOB_TIME)):
        time = 0.01 * index
        thrust = hover * (1.0 + 0.12 * math.cos(rate * time) / slope + bias)
        velocity = GRAVITY * 0.12 / rate * math.sin(rate * (time - delay)) + noise * random.standard_normal()
        samples.append(
            VehicleSample(
                velocity=np.array([0.0, 0.0, velocity]), position_time=time - time % 0.02, thrust_target=thrust,
                thrust_target_time=time - time % 0.05,
            )
        )  # fmt: skip
    found = measured_slope(samples, hover)
    assert found is not None
    return found


@pytest.mark.parametrize("slope", [1.0, 1.4, 2.0])
@pytest.mark.parametrize(("delay", "noise"), [(0.0, 0.0), (0.04, 0.01), (0.12, 0.02)])
def test_motors_that_lag_and_velocities_that_are_noisy_leave_the_slope(slope, delay, noise):
    found = measured(slope, 0.55, delay, noise, bias=0.01)
    assert abs(found.value - slope) < max(0.05, 2.0 * found.deviation) and found.deviation < 0.3


def test_too_little_tells_nothing():
    assert measured_slope([], 0.5) is None
    assert measured(1.0, 0.5, 0.0, 0.5).deviation > 0.3, "and noise says that it is noise"


@pytest.mark.parametrize(
    ("slope", "grounded"),
    [(None, False), (Slope(1.0, 0.02), False), (Slope(2.05, 0.05), False), (Slope(0.4, 0.05), True),
     (Slope(3.1, 0.05), True), (Slope(3.1, 0.6), False)],
)  # fmt: skip
def test_thrust_that_does_not_follow_grounds_the_vehicle_with_the_reason(slope, grounded):
    assert ("THR_MDL_FAC" in judge_slope(slope)) is grounded


def test_squared_motors_are_flown_by_newtons(rigs):
    """An autopilot that takes a fifth of the signal for the thrust: what is sent makes the newtons that are meant."""
    hover, k = 0.6, 0.2
    rig = rigs("px4", {"thrust_curve": None, "hover_force": WEIGHT}, motors="quadratic", hover_thrust=hover, pace=1.0)
    rig.emulator.parameters["THR_MDL_FAC"] = k
    u = math.sqrt(hover)
    rig.emulator.parameters["MPC_THR_HOVER"] = k * u * u + (1.0 - k) * u
    rig.fly()
    state = rig.pilot.state()
    curve = rig.pilot.calibrate_hover(WEIGHT, 1.0)
    slope = rig.pilot.measure_slope(PositionSetpoint(state.position, 0.0))
    assert slope is not None and slope.deviation < 0.1
    curve = rig.pilot.shape_thrust(slope.shape(curve.hover_thrust))
    for share in (0.9, 1.1):
        thrust = curve.normalised(share * WEIGHT)
        assert thrust_share(thrust, k) * WEIGHT / hover == pytest.approx(share * WEIGHT, rel=0.035), (
            slope
        )  # by a line: 8 % off
    assert rig.pilot.setpoint(AttitudeSetpoint(WEIGHT, np.zeros(3)))


def relative(signal: float, k: float) -> float:
    return k * signal * signal + (1.0 - k) * signal


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.2, 0.9))
def test_the_right_value_of_the_autopilots_parameter_is_the_motors_own_curve(motors, given_value, signal):
    hover, step = relative(signal, given_value), 1e-6
    force, thrust = (
        (relative(signal + step, k) - relative(signal - step, k)) / relative(signal, k) for k in (motors, given_value)
    )
    model = ThrustModel("THR_MDL_FAC", given_value)
    assert model.right_value(Slope(force / thrust, 0.0), hover) == pytest.approx(motors, abs=1e-3)


@pytest.mark.parametrize(
    ("slope", "refused"),
    [(None, False), (Slope(1.25, 0.05), False), (Slope(0.75, 0.05), False), (Slope(2.0, 0.05), True), (Slope(0.6, 0.05), True),
     (Slope(2.0, 0.6), False)],
)  # fmt: skip
def test_a_push_bears_less_of_a_wrong_curve_than_flight(slope, refused):
    assert not judge_slope(slope)
    for model in (ThrustModel("MOT_THST_EXPO", 0.0), None):
        assert bool(judge_model(slope, model, 0.7)) is refused


@pytest.mark.parametrize(("flavour", "name"), [("px4", "THR_MDL_FAC"), ("ardupilot", "MOT_THST_EXPO")])
def test_a_wrong_thrust_curve_is_refused_for_a_push_and_named(rigs, flavour, name):
    """Motors whose thrust is the signal squared, behind an autopilot that takes the signal for the thrust."""
    hover = 0.5
    rig = rigs(flavour, {"thrust_curve": None, "hover_force": WEIGHT}, motors="quadratic", hover_thrust=hover, pace=1.0)
    rig.emulator.parameters[name] = 0.0
    rig.emulator.parameters[rig.emulator.build.dialect.hover_thrust] = math.sqrt(hover)
    rig.fly()
    at = PositionSetpoint(rig.pilot.state().position, 0.0)
    reason = measure_hover(rig.pilot, at, str, dict, steepest=STEEPEST)
    set_to = float(re.search(rf"set {name} to ([0-9.]+)", reason)[1])
    assert f"{name} is 0.00" in reason and set_to > 0.8, reason
    assert not measure_hover(rig.pilot, at, str, dict), "a grip flies by the slope that was measured"
