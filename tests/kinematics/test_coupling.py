"""The kinematic constraint, its Jacobians, and the state conversion both ways."""

from __future__ import annotations

import math

import numpy as np
import pytest
from attitude_matrices import euler_rate_matrix
from finite_differences import central_difference
from hypothesis import given
from hypothesis import strategies as st
from urdf_variants import DOOR, VEHICLE

from doorman.exceptions import DimensionError
from doorman.kinematics.coupling import Coupling, distance_in_doorway
from doorman.kinematics.doors.door import Door
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.vehicle import Vehicle

PAPER = Coupling(Vehicle(VEHICLE), Door(DOOR), 0.7, 0.8)


def test_tips_of_many_postures_are_those_of_each(coupling: Coupling) -> None:
    rng, n = np.random.default_rng(4), coupling.vehicle.n_arm
    attitudes, arms = rng.uniform(-1.4, 1.4, (6, 3)), rng.uniform(-2.0, 2.0, (6, n))
    expected = [
        rotation_body_to_world(attitude) @ coupling.vehicle.tip_position(arm)
        for attitude, arm in zip(attitudes, arms, strict=True)
    ]
    np.testing.assert_allclose(coupling.tips(attitudes, arms), expected, atol=1e-13)
    strided = np.hstack([attitudes, arms])
    np.testing.assert_array_equal(coupling.tips(strided[:, :3], strided[:, 3:]), coupling.tips(attitudes, arms))


def random_state(n: int, rng: np.random.Generator) -> np.ndarray:
    return np.concatenate(
        [rng.uniform(-1.2, 1.2, 3), rng.uniform(-0.3, 1.7, 1), rng.normal(size=1), rng.uniform(-1.5, 1.5, n)]
    )


def test_the_tip_lies_on_the_leaf(coupling: Coupling, rng: np.random.Generator) -> None:
    for _ in range(5):
        x = random_state(coupling.vehicle.n_arm, rng)
        position = coupling.vehicle_position(x[:3], x[3], x[5:])
        tip = position + rotation_body_to_world(x[:3]) @ coupling.vehicle.tip_position(x[5:])
        np.testing.assert_allclose(tip, coupling.door.contact_point(x[3], 0.65, 0.9), atol=1e-14)


def test_start_of_the_paper_by_hand() -> None:
    """Closed door, level, arm stretched ahead: the vehicle is 0.502 m before the leaf and 0.066 m above the contact."""
    position = PAPER.vehicle_position([0, 0, 0], math.pi / 2, [0, math.pi / 2, -math.pi / 2, 0])
    np.testing.assert_allclose(position, [-0.502, 0.7, 1.266], atol=1e-15)


@given(st.floats(0.3, 0.8), st.floats(0.6, 1.2))
def test_a_vehicle_behind_its_tip_just_fits_the_doorway(reach: float, room: float) -> None:
    """At the door angle where it comes nearest to the latch jamb, its centre is as far from the hinge's side as it may be."""
    distance = distance_in_doorway(reach, max(room, reach))
    angles, beside = np.linspace(0.0, math.pi / 2, 20001), math.radians(14.0)
    from_the_hinge = distance * np.sin(angles) + reach * np.cos(angles + beside)
    assert from_the_hinge.max() == pytest.approx(max(room, reach), abs=1e-6)


def test_vehicle_motion_is_the_derivative_of_the_position(coupling: Coupling, rng: np.random.Generator) -> None:
    n = coupling.vehicle.n_arm
    for _ in range(5):
        x, body_rates, arm_rates = random_state(n, rng), rng.normal(size=3), rng.normal(size=n)
        motion = coupling.vehicle_motion(x, body_rates, arm_rates)
        q = np.concatenate([x[:4], x[5:]])
        q_rate = np.concatenate([euler_rate_matrix(x[:3]) @ body_rates, x[4:5], arm_rates])

        def position(t: np.ndarray, q: np.ndarray = q, q_rate: np.ndarray = q_rate) -> np.ndarray:
            moved = q + t[0] * q_rate
            return coupling.vehicle_position(moved[:3], moved[3], moved[4:])

        np.testing.assert_allclose(motion.position, position(np.zeros(1)), atol=1e-15)
        np.testing.assert_allclose(motion.velocity, central_difference(position, np.zeros(1))[:, 0], atol=1e-8)


@pytest.mark.parametrize("around", [None, 0.0, math.pi / 2, -math.pi / 2, -3.1])
def test_door_state_undoes_vehicle_motion(coupling: Coupling, around: float | None, rng: np.random.Generator) -> None:
    """At random angles of the door, and where sines and cosines are 0."""
    n = coupling.vehicle.n_arm
    for _ in range(5):
        x, body_rates, arm_rates = random_state(n, rng), rng.normal(size=3), rng.normal(size=n)
        x[3] = x[3] if around is None else around
        motion = coupling.vehicle_motion(x, body_rates, arm_rates)
        angle, rate = coupling.door_state(motion.position, motion.velocity, x[:3], body_rates, x[5:], arm_rates)
        assert angle == pytest.approx(x[3], abs=1e-13)
        assert rate == pytest.approx(x[4], abs=1e-12)


def test_door_rate_is_that_of_the_tip_across_the_leaf() -> None:
    """A tip that slides along the leaf does not turn the door."""
    x = np.array([0, 0, 0, 0.6, 0.0, 0, 0, 0, 0])
    motion = PAPER.vehicle_motion(x, np.zeros(3), np.zeros(4))
    sliding = 0.2 * np.array([math.cos(0.6), math.sin(0.6), 0.0])
    _, rate = PAPER.door_state(motion.position, sliding, x[:3], np.zeros(3), x[5:], np.zeros(4))
    assert rate == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("state", [np.zeros(8), np.zeros(10), np.full(9, math.nan), np.zeros((9, 1))])
def test_what_is_not_a_state_is_an_error(state: np.ndarray) -> None:
    with pytest.raises(DimensionError, match="state"):
        PAPER.vehicle_motion(state, np.zeros(3), np.zeros(4))


@pytest.mark.parametrize(
    ("field", "bad"),
    [
        ("position", np.zeros(2)),
        ("velocity", np.full(3, math.nan)),
        ("attitude", np.zeros(4)),
        ("body_rates", np.zeros(1)),
        ("arm_angles", np.zeros(3)),
        ("arm_rates", np.zeros(1)),
    ],
)
def test_what_is_not_a_measurement_is_an_error(field: str, bad: np.ndarray) -> None:
    arguments = {name: np.zeros(3) for name in ("position", "velocity", "attitude", "body_rates")}
    arguments |= {"arm_angles": np.zeros(4), "arm_rates": np.zeros(4), field: bad}
    with pytest.raises(DimensionError, match=field):
        PAPER.door_state(**arguments)
