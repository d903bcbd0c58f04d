"""Quaternions against Pinocchio's rotations."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from doorman.exceptions import DimensionError
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
from doorman.kinematics.rotations import attitude_from_rotation, quaternion_of, rotation_body_to_world

angle = st.floats(-3.1, 3.1)
length = st.floats(-10.0, 10.0)
angles = st.tuples(angle, st.floats(-1.5, 1.5), angle)
places = st.tuples(length, length, length)


def matrix(quaternion):
    w, x, y, z = quaternion
    return pin.Quaternion(w, x, y, z).matrix()


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
    assert matrix(from_rotation_vector(vector)) == pytest.approx(pin.exp3(np.array(vector)), abs=1e-9)
    assert rotation_vector(from_rotation_vector(vector)) == pytest.approx(vector, abs=1e-6)


@settings(max_examples=40)
@given(angles, angles, places)
def test_products_and_rotations(first, second, vector):
    a, b = quaternion_of(first), quaternion_of(second)
    assert matrix(multiply(a, b)) == pytest.approx(matrix(a) @ matrix(b), abs=1e-12)
    assert rotate(a, vector) == pytest.approx(matrix(a) @ np.array(vector), abs=1e-9)
    assert angle_between(a, b) == pytest.approx(np.linalg.norm(pin.log3(matrix(a).T @ matrix(b))), abs=1e-6)
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
