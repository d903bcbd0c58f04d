"""The mixer: exact where it can be, and the right things given up where it cannot."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from doorman.exceptions import BackendError
from doorman.kinematics.vehicles.rotor_layout import RotorLayout, rotor_layout
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.resources import urdf_directory
from doorman.scenario import VehicleSection
from doorman.simulation.plant.onboard.rotors import MixerParameters, mix

VEHICLE = Vehicle(urdf_directory() / "hexarotor_arm.urdf")
LAYOUT = rotor_layout(VEHICLE, 0.016)
demands = st.tuples(st.floats(-20, 80), st.floats(-9, 9), st.floats(-9, 9), st.floats(-2, 2))


def mixed(
    thrust: float, torque: tuple[float, float, float], layout: RotorLayout = LAYOUT
) -> tuple[np.ndarray, np.ndarray]:
    parameters = MixerParameters.of(layout)
    mix(parameters, thrust, np.array(torque, dtype=float))
    return parameters.thrusts, parameters.achieved


def test_demand_inside_the_limits_is_met_exactly():
    thrusts, achieved = mixed(30.0, (0.8, -0.9, 0.05))
    assert np.allclose(achieved, [30.0, 0.8, -0.9, 0.05], atol=1e-12)
    assert np.allclose(LAYOUT.allocation @ thrusts, achieved, atol=1e-12)


@given(demands)
@settings(max_examples=300, deadline=None)
def test_limits_and_priorities(demand):
    thrust, roll, pitch, yaw = demand
    thrusts, achieved = mixed(thrust, (roll, pitch, yaw))
    assert (thrusts >= 0.0).all() and (thrusts <= LAYOUT.max_thrusts).all()
    assert np.allclose(LAYOUT.allocation @ thrusts, achieved, atol=1e-9)
    # a yaw demand changes nothing of thrust, roll and pitch, and is met in part and never reversed
    _, without = mixed(thrust, (roll, pitch, 0.0))
    assert np.allclose(achieved[:3], without[:3], atol=1e-9)
    assert -1e-9 <= achieved[3] * np.sign(yaw) <= abs(yaw) + 1e-9
    # roll and pitch keep their ratio, and are cut only at a rotor's both ends
    share = np.hypot(*achieved[1:3]) / max(np.hypot(roll, pitch), 1e-12)
    if np.hypot(roll, pitch) > 1e-6:
        assert np.allclose(achieved[1:3], share * np.array([roll, pitch]), atol=1e-9)
        if share < 1.0 - 1e-9:
            assert without_yaw_is_at_both_ends(thrust, roll, pitch)


def without_yaw_is_at_both_ends(thrust: float, roll: float, pitch: float) -> bool:
    thrusts, _ = mixed(thrust, (roll, pitch, 0.0))
    return bool(thrusts.min() < 1e-9 and (LAYOUT.max_thrusts - thrusts).min() < 1e-9)


@given(st.floats(-20, 80), st.floats(-2, 2), st.floats(-2, 2))
@settings(max_examples=200, deadline=None)
def test_thrust_moves_no_more_than_roll_and_pitch_need(thrust, roll, pitch):
    thrusts, achieved = mixed(thrust, (roll, pitch, 0.0))
    assert np.allclose(achieved[1:3], [roll, pitch], atol=1e-9)
    if achieved[0] > thrust + 1e-9:
        assert thrusts.min() < 1e-9
    if achieved[0] < thrust - 1e-9:
        assert (LAYOUT.max_thrusts - thrusts).min() < 1e-9


def test_ring_of_six_where_the_urdf_names_no_rotors(tmp_path):
    text = (urdf_directory() / "hexarotor_arm.urdf").read_text().replace('name="rotor_', 'name="motor_')
    path = tmp_path / "no_rotors.urdf"
    path.write_text(text.replace('child link="rotor_', 'child link="motor_'))
    vehicle = Vehicle(path, VehicleSection(radius=0.5, max_thrust=60.0))
    layout = rotor_layout(vehicle, 0.02)
    assert layout.count == 6 and layout.max_thrusts.sum() == pytest.approx(60.0)
    assert np.allclose(np.linalg.norm(layout.positions, axis=1), 0.35)
    assert np.allclose(mixed(30.0, (1.0, -1.0, 0.1), layout)[1], [30.0, 1.0, -1.0, 0.1])


def test_thrust_limit_of_the_scenario_scales_the_rotors():
    vehicle = Vehicle(urdf_directory() / "hexarotor_arm.urdf", VehicleSection(max_thrust=36.0))
    assert np.allclose(rotor_layout(vehicle, 0.016).max_thrusts, 6.0)


def test_rotors_that_cannot_turn_the_vehicle_are_refused(tmp_path):
    path = tmp_path / "one_sense.urdf"
    text = (urdf_directory() / "hexarotor_arm.urdf").read_text()
    one_sense = text.replace(
        '<axis xyz="0 0 -1"/>\n    <limit effort="8.0"', '<axis xyz="0 0 1"/>\n    <limit effort="8.0"'
    )
    assert one_sense != text
    path.write_text(one_sense)
    with pytest.raises(BackendError, match="all three axes") as caught:
        rotor_layout(Vehicle(path), 0.016)
    assert caught.value.file == str(path)
