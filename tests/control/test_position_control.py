"""Position controller: law, saturation, and the attitude that goes with a force."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.control.position_controller import PositionController, Setpoint, attitude_of_force, saturate
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.scenario import ControlSection

GRAVITY, MASS = 9.81, 3.0
component = st.floats(-40.0, 40.0)


def setpoint(**changes) -> Setpoint:
    rest = np.zeros(3)
    values = {"position": rest, "velocity": rest, "acceleration": rest, "yaw": 0.0, "force": rest, "normal": rest,
              "arm_rates": np.zeros(4)}  # fmt: skip
    return Setpoint(**{**values, **changes})


@given(component, component, st.floats(0.5, 48.0), st.floats(-3.1, 3.1))
def test_body_axis_points_along_the_force(x: float, y: float, z: float, yaw: float) -> None:
    force = np.array([x, y, z])
    attitude = attitude_of_force(force, yaw)
    np.testing.assert_allclose(rotation_body_to_world(attitude)[:, 2], force / np.linalg.norm(force), atol=1e-12)
    assert attitude[2] == yaw


@given(component, component, component, st.floats(0.05, 1.0))
def test_saturation_keeps_thrust_and_tilt(x: float, y: float, z: float, max_tilt: float) -> None:
    force = saturate(np.array([x, y, z]), 48.0, max_tilt)
    assert np.linalg.norm(force) <= 48.0 * (1 + 1e-12)
    assert force[2] > 0.0
    assert np.hypot(force[0], force[1]) <= force[2] * np.tan(max_tilt) * (1 + 1e-9) + 1e-12
    assert force[0] * y == pytest.approx(force[1] * x, abs=1e-9)  # its direction is kept


def test_a_vehicle_that_lacks_lift_holds_against_the_side_none_the_less() -> None:
    force = saturate(np.array([6.0, 0.0, 90.0]), 48.0, 0.3)
    assert force[0] == pytest.approx(6.0) and force[2] == pytest.approx(math.sqrt(48.0**2 - 6.0**2))
    strong = saturate(np.array([30.0, 0.0, 90.0]), 48.0, 0.3)
    assert strong[0] == pytest.approx(0.25 * 48.0) and strong[2] > 0.96 * 48.0


def test_rotors_that_make_less_are_asked_for_no_more_and_the_rest_is_no_disturbance() -> None:
    controller = PositionController(MASS, GRAVITY, 48.0, ControlSection())
    controller.reach = 0.8
    for k in range(200):  # sinks, as it would: what lifts is all that there is
        controller.update(np.array([0.0, 0.0, -1.0 - 0.01 * k]), np.zeros(3), setpoint(), 0.004)
    thrust = controller.update(np.array([0.0, 0.0, -3.0]), np.zeros(3), setpoint(), 0.004)
    assert thrust.thrust == pytest.approx(0.8 * 48.0) and thrust.saturated


def test_a_setpoint_may_allow_more_tilt() -> None:
    controller, far = PositionController(MASS, GRAVITY, 48.0, ControlSection()), np.array([9.0, 0.0, 0.0])
    for given_, expected in ((None, ControlSection().max_tilt), (0.4, 0.4)):
        thrust = controller.update(np.zeros(3), np.zeros(3), setpoint(position=far, max_tilt=given_), 0.004)
        assert thrust.saturated and thrust.attitude[1] == pytest.approx(expected)


def test_holds_a_position_under_a_constant_disturbance() -> None:
    controller = PositionController(MASS, GRAVITY, 48.0, ControlSection())
    position, velocity, gust = np.zeros(3), np.zeros(3), np.array([1.0, -0.5, -2.0])
    for _ in range(5000):
        force = controller.update(position, velocity, setpoint(), 0.004).force
        velocity = velocity + 0.004 * ((force + gust) / MASS - np.array([0.0, 0.0, GRAVITY]))
        position = position + 0.004 * velocity
    np.testing.assert_allclose(position, 0.0, atol=1e-3)
    np.testing.assert_allclose(controller.observer.estimate, gust, atol=1e-2)


def test_a_tip_that_touches_nothing_learns_the_wind_slowly() -> None:
    controller = PositionController(MASS, GRAVITY, 48.0, ControlSection())
    position, velocity, gust, found = np.zeros(3), np.zeros(3), np.array([0.0, 1.0, 0.0]), []
    for step in range(5000):
        touches = step >= 4000
        gust[1] = 1.0 if step < 4000 else -1.0
        force = np.array([1.0, 0.0, 0.0]) if touches else np.zeros(3)
        wanted = setpoint(normal=np.array([1.0, 0.0, 0.0]), push=1.0, force=force)
        thrust = controller.update(position, velocity, wanted, 0.004)
        acting = thrust.force - np.array([0.0, 0.0, MASS * GRAVITY]) + gust
        acting[0] = 0.0  # something holds it there
        velocity = velocity + 0.004 * acting / MASS
        position = position + 0.004 * velocity
        found.append(float(thrust.disturbance[1]))
    assert found[250] < 0.6, "a gust of a second is not believed whole"
    assert found[3999] == pytest.approx(1.0, abs=0.05)
    assert found[4999] == pytest.approx(found[4000], abs=1e-9), "what the tip feels when it touches is no wind"


def test_an_error_does_not_wind_up_against_a_tip_that_sticks() -> None:
    forces = []
    for push in (None, 2.0):
        controller = PositionController(MASS, GRAVITY, 48.0, ControlSection())
        normal = np.array([1.0, 0.0, 0.0])
        force = np.zeros(3) if push is None else push * normal
        wanted = setpoint(position=np.array([0.0, 0.1, 0.05]), normal=normal, push=push, force=force)
        found = [controller.update(np.zeros(3), np.zeros(3), wanted, 0.004).force for _ in range(1500)]
        forces.append((found[0], found[-1]))
    (_, free), (first, held) = forces
    assert held[1] == pytest.approx(first[1], abs=1e-6)
    assert held[2] == pytest.approx(first[2] + 0.7, abs=0.03)
    assert free[1] > first[1] + 0.5 and free[2] > first[2] + 1.0


def test_a_vehicle_that_grips_does_not_hang_on_the_handle() -> None:
    """Arm and hinge carry what the thrust does not, and that is no lift; a handle's pull to the side is one like any other."""
    wanted = setpoint(
        position=np.array([0.0, 0.1, -0.05]), force=np.array([2.0, 0.0, 0.0]), normal=np.array([1.0, 0.0, 0.0])
    )
    controller = PositionController(MASS, GRAVITY, 48.0, ControlSection())
    held = [controller.update(np.zeros(3), np.zeros(3), wanted, 0.004) for _ in range(5000)]
    assert held[-1].force[2] == pytest.approx(held[0].force[2] - 0.7, abs=0.03)
    assert held[-1].force[1] > held[0].force[1] + 0.5
    lifts = np.array(
        [controller.update(np.zeros(3), np.zeros(3), setpoint(), 0.004).disturbance[2] for _ in range(250)]
    )
    assert np.abs(np.diff([held[-1].disturbance[2], *lifts])).max() < 0.1, "and nothing jumps when it lets go"
