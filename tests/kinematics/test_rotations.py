"""Attitude: rotation matrices, Euler rates and their singularity, and quaternions, against Pinocchio."""

from __future__ import annotations

import math

import numpy as np
import pinocchio
import pytest
from finite_differences import central_difference
from hypothesis import given, settings
from hypothesis import strategies as st

from doorman.exceptions import DimensionError, SingularityError
from doorman.kinematics.quaternions import (
    angle_between,
    conjugate,
    from_rotation_vector,
    multiply,
    rotate,
    rotation_vector,
    to_attitude,
    to_rotation,
    unit_quaternion,
    wrap,
)
from doorman.kinematics.rotations import (
    attitude_from_rotation,
    body_rates_of,
    euler_rates,
    quaternion_of,
    rotation_body_to_world,
)

turns = st.floats(-math.pi + 1e-9, math.pi - 1e-9)
any_attitudes = st.tuples(*[st.floats(-10.0, 10.0)] * 3).map(np.array)


@given(any_attitudes)
def test_rotation_agrees_with_pinocchio(attitude: np.ndarray) -> None:
    np.testing.assert_allclose(rotation_body_to_world(attitude), pinocchio.rpy.rpyToMatrix(attitude), atol=1e-14)


def test_body_rates_are_those_of_the_rotation(rng: np.random.Generator) -> None:
    for _ in range(20):
        attitude, rates = rng.uniform(-1.4, 1.4, 3), rng.normal(size=3)
        derivative = central_difference(
            lambda t, a=attitude, r=rates: rotation_body_to_world(a + t[0] * r), np.zeros(1)
        )
        body_rates = body_rates_of(attitude[None], rates[None])[0]
        spin = rotation_body_to_world(attitude).T @ derivative[..., 0]
        np.testing.assert_allclose(spin, np.cross(body_rates, np.eye(3)).T, atol=1e-9)
        np.testing.assert_allclose(euler_rates(attitude, body_rates), rates, atol=1e-12)


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
def test_the_singularity_is_an_error(pitch: float) -> None:
    with pytest.raises(SingularityError) as caught:
        euler_rates([0.3, pitch, -0.2], np.ones(3))
    assert (caught.value.field, caught.value.given) == ("attitude[1]", pitch)
    with pytest.raises(SingularityError):
        attitude_from_rotation(rotation_body_to_world([0.3, pitch, -0.2]))


@pytest.mark.parametrize("attitude", [[0.0, 0.0], [0.0, math.nan, 0.0], [0.0, math.inf, 0.0], "level", [[0.0] * 3]])
def test_what_is_not_an_attitude_is_an_error(attitude: object) -> None:
    with pytest.raises(DimensionError, match="attitude"):
        rotation_body_to_world(attitude)  # type: ignore[arg-type]


angle = st.floats(-3.1, 3.1)
length = st.floats(-10.0, 10.0)
angles = st.tuples(angle, st.floats(-1.5, 1.5), angle)
places = st.tuples(length, length, length)


def matrix(quaternion):
    w, x, y, z = quaternion
    return pinocchio.Quaternion(w, x, y, z).matrix()


@given(angles)
def test_attitudes_are_those_of_the_library(attitude):
    quaternion = quaternion_of(attitude)
    assert np.linalg.norm(quaternion) == pytest.approx(1.0)
    assert matrix(quaternion) == pytest.approx(rotation_body_to_world(attitude), abs=1e-12)
    assert to_rotation(2.0 * np.array(quaternion)) == pytest.approx(matrix(quaternion), abs=1e-12)
    assert to_attitude(quaternion) == pytest.approx(attitude_from_rotation(matrix(quaternion)), abs=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("yaw", [-2.0, 0.0, 1.0])
def test_attitude_standing_upright_has_a_rotation_still(sign, yaw):
    quaternion = quaternion_of((0.4, sign * math.pi / 2, yaw))
    attitude = to_attitude(quaternion)
    assert attitude[:2] == pytest.approx((0.0, sign * math.pi / 2))
    assert rotation_body_to_world(attitude) == pytest.approx(matrix(quaternion), abs=1e-6)


@settings(max_examples=40)
@given(places.filter(lambda v: np.linalg.norm(v) < 3.1))
def test_rotation_vectors_are_the_logarithm(vector):
    assert matrix(from_rotation_vector(vector)) == pytest.approx(pinocchio.exp3(np.array(vector)), abs=1e-9)
    assert rotation_vector(from_rotation_vector(vector)) == pytest.approx(vector, abs=1e-6)


@settings(max_examples=40)
@given(angles, angles, places)
def test_products_and_rotations(first, second, vector):
    a, b = quaternion_of(first), quaternion_of(second)
    assert matrix(multiply(a, b)) == pytest.approx(matrix(a) @ matrix(b), abs=1e-12)
    assert rotate(a, vector) == pytest.approx(matrix(a) @ np.array(vector), abs=1e-9)
    assert angle_between(a, b) == pytest.approx(np.linalg.norm(pinocchio.log3(matrix(a).T @ matrix(b))), abs=1e-6)
    assert angle_between(a, tuple(-value for value in a)) == pytest.approx(0.0, abs=1e-7)
    assert matrix(conjugate(a)) == pytest.approx(matrix(a).T, abs=1e-12)


@given(st.floats(-50.0, 50.0))
def test_wrapped_angles_are_the_same_angles_in_range(angle):
    wrapped = wrap(angle)
    assert -math.pi < wrapped <= math.pi + 1e-12
    assert math.cos(wrapped - angle) == pytest.approx(1.0)


@pytest.mark.parametrize("values", [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0], [math.nan, 0, 0, 1]])
def test_what_is_no_unit_quaternion_is_refused(values):
    with pytest.raises(DimensionError, match="attitude"):
        unit_quaternion(values, "attitude")


def test_a_quaternion_that_is_nearly_unit_is_normalised():
    assert np.linalg.norm(unit_quaternion([1.005, 0.0, 0.0, 0.0], "attitude")) == pytest.approx(1.0, abs=1e-15)
