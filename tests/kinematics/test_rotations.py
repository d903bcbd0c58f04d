"""Attitude: rotation matrices, Euler rates and their singularity."""

from __future__ import annotations

import math

import numpy as np
import pinocchio
import pytest
from finite_differences import central_difference
from hypothesis import given
from hypothesis import strategies as st

from doorman.exceptions import DimensionError, SingularityError
from doorman.kinematics.rotations import (
    attitude_from_rotation,
    body_rates_of,
    euler_rates,
    rotation_body_to_world,
)

turns = st.floats(-math.pi + 1e-9, math.pi - 1e-9)
attitudes = st.tuples(turns, st.floats(-1.5, 1.5), turns).map(np.array)
any_attitudes = st.tuples(*[st.floats(-10.0, 10.0)] * 3).map(np.array)


@given(any_attitudes)
def test_rotation_agrees_with_pinocchio(attitude: np.ndarray) -> None:
    np.testing.assert_allclose(rotation_body_to_world(attitude), pinocchio.rpy.rpyToMatrix(attitude), atol=1e-14)


@given(attitudes)
def test_attitude_survives_the_way_through_a_rotation(attitude: np.ndarray) -> None:
    np.testing.assert_allclose(attitude_from_rotation(rotation_body_to_world(attitude)), attitude, atol=1e-13)


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
