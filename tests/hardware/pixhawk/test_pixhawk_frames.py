"""Conversions of frames: inverses, isometries, homomorphisms, and agreement with rotation matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.hardware.pixhawk.wire import frames
from doorman.hardware.pixhawk.wire.frames import LocalFrame
from doorman.kinematics import quaternions
from doorman.kinematics.rotations import quaternion_of

numbers = st.floats(-100.0, 100.0)
vectors = st.tuples(numbers, numbers, numbers).map(np.array)
angles = st.floats(-math.pi, math.pi)
attitudes = st.tuples(angles, st.floats(-1.5, 1.5), angles).map(np.array)
attitude_quaternions = attitudes.map(quaternion_of)
local_frames = st.builds(LocalFrame, st.tuples(numbers, numbers, numbers), angles)

HALF_TURN = np.diag([1.0, -1.0, -1.0])


def matrix(quaternion):
    """Rotation matrix of a quaternion, column by column."""
    return np.column_stack([quaternions.rotate(quaternion, axis) for axis in np.eye(3)])


def same_rotation(first, second):
    return abs(abs(float(np.dot(first, second))) - 1.0) < 1e-9


def test_the_facts_that_hardware_was_measured_with():
    assert frames.world_to_ned([1.0, 2.0, 3.0]).tolist() == [1.0, -2.0, -3.0]
    assert frames.quaternion_world_to_ned([0.1, 0.2, 0.3, 0.4]).tolist() == [0.1, 0.2, -0.3, -0.4]
    assert LocalFrame().yaw_to_ned(0.4) == pytest.approx(-0.4)


@given(attitude_quaternions, vectors)
def test_attitude_and_vectors_are_converted_alike(q, v):
    """Turning a body vector and then converting is converting and then turning."""
    in_ned = quaternions.rotate(frames.quaternion_world_to_ned(q), frames.flu_to_frd(v))
    assert np.allclose(in_ned, frames.world_to_ned(quaternions.rotate(q, v)), atol=1e-9)


@given(local_frames, vectors, attitude_quaternions)
def test_local_frames_come_back(frame, v, q):
    assert np.allclose(frame.position_to_world(frame.position_to_ned(v)), v, atol=1e-9)
    assert np.allclose(frame.vector_to_world(frame.vector_to_ned(v)), v, atol=1e-9)
    assert same_rotation(frame.quaternion_to_world(frame.quaternion_to_ned(q)), q)


@given(local_frames, angles)
def test_yaw_of_a_local_frame_is_that_of_its_attitude(frame, yaw):
    q = frame.quaternion_to_ned(quaternion_of([0.0, 0.0, yaw]))
    assert math.cos(quaternions.to_attitude(q)[2] - frame.yaw_to_ned(yaw)) == pytest.approx(1.0)


@given(vectors, angles, vectors, angles)
def test_a_frame_through_a_known_pose_maps_it(place, yaw, reported, reported_yaw):
    frame = LocalFrame.through(place, yaw, reported, reported_yaw)
    assert np.allclose(frame.position_to_world(reported), place, atol=1e-8)
    assert math.cos(frame.yaw_to_ned(yaw) - reported_yaw) == pytest.approx(1.0)


def test_north_of_a_turned_frame_points_along_its_yaw():
    frame = LocalFrame((1.0, 2.0, 3.0), math.pi / 2)
    assert np.allclose(frame.position_to_world([1.0, 0.0, 0.0]), [1.0, 3.0, 3.0])
    assert np.allclose(frame.vector_to_world([0.0, 1.0, 0.0]), [1.0, 0.0, 0.0])
