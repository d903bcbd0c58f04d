"""Landing gear: it carries the weight, rights the vehicle, resists sliding and pushes nobody who is in the air."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.rig.landing_gear import LandingGear

GEAR = LandingGear(0.24)
UP = np.array([0.0, 0.0, 1.0])
speeds = st.floats(-2.0, 2.0)


def wrench(height, velocity=(0.0, 0.0, 0.0), up=UP, spin=(0.0, 0.0, 0.0)):
    return GEAR.wrench(np.array([0.0, 0.0, height]), np.array(velocity), np.asarray(up), np.array(spin))


@given(st.floats(0.2401, 5.0), speeds, speeds, speeds)
def test_nothing_in_the_air(height, x, y, z):
    force, torque = wrench(height, (x, y, z), spin=(x, y, z))
    assert not force.any()
    assert not torque.any()


def test_it_carries_the_weight_at_a_small_deflection():
    weight = 3.0 * 9.81
    force, _ = wrench(GEAR.length - weight / GEAR.stiffness)
    assert force == pytest.approx([0.0, 0.0, weight])
    assert weight / GEAR.stiffness < 0.02


@given(st.floats(0.0, 0.24), speeds, speeds, speeds)
def test_it_never_pulls_and_never_drives(height, x, y, z):
    force, _ = wrench(height, (x, y, z))
    assert force[2] >= 0.0
    assert force[0] * x + force[1] * y <= 0.0
    assert np.hypot(force[0], force[1]) <= GEAR.friction * force[2] + 1e-9


def test_it_rights_a_tilted_vehicle():
    """A body whose z axis leans to +x has turned about +y; the torque turns it back."""
    _, torque = wrench(0.2, up=[0.1, 0.0, 0.995])
    assert torque[1] < 0.0
    assert torque[0] == pytest.approx(0.0)
    _, torque = wrench(0.2, up=[0.0, 0.1, 0.995])
    assert torque[0] > 0.0


@given(speeds, speeds, speeds)
def test_it_stops_turning(x, y, z):
    _, torque = wrench(0.2, spin=(x, y, z))
    assert torque @ np.array([x, y, z]) <= 0.0
