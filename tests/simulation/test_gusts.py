"""Wind on vehicle and leaf, against its definition and against the plant's motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from urdf_variants import DOOR

from doorman.hardware.interface import Command
from doorman.kinematics.doors.door import Door
from doorman.scenario import GustSection
from doorman.simulation import Disturbance, SimulatedBackend
from doorman.simulation.gusts import Gust, together

SHIPPED = Door(DOOR)
STEADY = {"simulation__gust__variation": 0.0}


def series(gust: Gust, seconds: float, step: float = 0.001) -> np.ndarray:
    """Force along x and hinge torque of a wind along x on a closed door of width 1.2 m."""
    found = [gust.at(k * step, math.pi / 2) for k in range(round(seconds / step))]
    return np.array([[one.force[0], one.hinge_torque] for one in found])


def test_a_steady_wind_is_its_mean():
    for direction in (0.0, 1.0, -2.5):
        gust = Gust(GustSection(vehicle=1.5, leaf=2.0, direction=direction, variation=0.0), SHIPPED, 0)
        for angle in (math.pi / 2, 0.7):
            found = gust.at(0.3, angle)
            wind = np.array([math.cos(direction), math.sin(direction), 0.0])
            np.testing.assert_allclose(found.force, 1.5 * wind, atol=1e-12)
            arm = 0.6 * np.array([math.cos(angle), math.sin(angle), 0.0])
            assert found.hinge_torque == pytest.approx(np.cross(arm, 2.0 * wind)[2], abs=1e-12)
            assert found.torque == (0.0, 0.0, 0.0)


def test_the_variation_has_its_deviation_and_its_correlation_time():
    section = GustSection(vehicle=2.0, leaf=1.0, variation=0.15)
    force, torque = series(Gust(section, SHIPPED, seed=11), 4000.0, step=0.02).T
    assert force.mean() == pytest.approx(2.0, rel=0.02) and force.std() == pytest.approx(0.3, rel=0.06)
    assert torque.mean() == pytest.approx(-0.6, rel=0.02) and torque.std() == pytest.approx(0.09, rel=0.06)
    for lag, kept in ((1, math.exp(-0.02)), (50, math.exp(-1.0)), (100, math.exp(-2.0))):
        assert np.corrcoef(force[:-lag], force[lag:])[0, 1] == pytest.approx(kept, abs=0.06)
    assert abs(np.corrcoef(force, torque)[0, 1]) < 0.1


def test_a_vertical_wind_rises_and_falls_about_zero_and_changes_no_other():
    section = GustSection(vehicle=1.0, vertical=0.4)
    gust, flat = Gust(section, SHIPPED, 11), Gust(section.model_copy(update={"vertical": 0.0}), SHIPPED, 11)
    both = [(gust.at(0.1 * k, 1.0), flat.at(0.1 * k, 1.0)) for k in range(20_000)]
    up = np.array([one.force[2] for one, _ in both])
    assert abs(up.mean()) < 0.05 and up.std() == pytest.approx(0.4, rel=0.06)
    assert np.corrcoef(up[:-10], up[10:])[0, 1] == pytest.approx(math.exp(-1.0), abs=0.06)
    assert all(one.force[:2] == other.force[:2] and other.force[2] == 0.0 for one, other in both)
    assert GustSection(vertical=0.1).blows


def test_disturbances_add_up():
    one = Disturbance(force=(1.0, 2.0, 3.0), torque=(0.1, 0.2, 0.3), hinge_torque=0.5)
    both = together(one, Disturbance(force=(0.5, 0.0, -3.0), torque=(0.0, 0.0, 1.0), hinge_torque=-1.0))
    assert both == Disturbance(force=(1.5, 2.0, 0.0), torque=(0.1, 0.2, 1.3), hinge_torque=-0.5)


def hovering(backend: SimulatedBackend, seconds: float) -> SimulatedBackend:
    with backend:
        for _ in range(round(seconds * 250) + 1):
            backend.read()
            backend.command(Command(3.0 * 9.81, np.zeros(3), np.zeros(4)))
    return backend


def test_the_wind_moves_vehicle_and_leaf(model):
    windy = model(contact__kind="push", simulation__gust__vehicle=1.5, simulation__gust__leaf=2.0,
                  simulation__gust__direction=math.pi, start__door_angle=1.2, **STEADY)  # fmt: skip
    truth = hovering(SimulatedBackend(windy), 0.4).truth
    assert truth.velocity[0] == pytest.approx(-1.5 / 3.0 * 0.4, rel=0.05)
    assert truth.door_rate == pytest.approx(0.6 * 2.0 * math.sin(1.2) / 5.28 * 0.4, rel=0.02)


def test_a_given_disturbance_acts_beside_the_wind(model):
    calm, windy = model(contact__kind="push"), model(contact__kind="push", simulation__gust__vehicle=1.2, **STEADY)
    push = Disturbance(force=(-1.2, 0.6, 0.0))
    velocity = hovering(SimulatedBackend(windy, disturbance=lambda time: push), 0.4).truth.velocity
    assert velocity[0] == pytest.approx(0.0, abs=5e-3) and velocity[1] == pytest.approx(0.6 / 3.0 * 0.4, rel=0.05)
    still = hovering(SimulatedBackend(calm), 0.4).truth.velocity
    assert np.abs(still).max() < 5e-3


@pytest.mark.parametrize("rate", [math.radians(9.0), -0.3])
def test_a_wind_of_constant_strength_turns(rate):
    gust = Gust(GustSection(vehicle=1.0, leaf=0.5, direction=0.4, turn_rate=rate, variation=0.0), SHIPPED, 3)
    for time in (0.0, 0.25, 5.0, 60.0):
        found, towards = gust.at(time, 0.9), 0.4 + rate * time
        np.testing.assert_allclose(found.force, [math.cos(towards), math.sin(towards), 0.0], atol=1e-12)
        assert found.hinge_torque == pytest.approx(0.6 * 0.5 * math.sin(towards - 0.9))


def test_a_wind_jumps_at_its_rate_by_its_angle_and_strength():
    section = GustSection(vehicle=2.0, variation=0.0, jump_rate=0.25)
    gust = Gust(section, SHIPPED, 6)
    forces = np.array([gust.at(0.1 * k, 1.0).force for k in range(40_000)])
    strength, towards = np.hypot(*forces[:, :2].T), np.arctan2(forces[:, 1], forces[:, 0])
    jumps = np.flatnonzero(np.abs(np.diff(strength)) > 1e-9)
    assert len(jumps) == pytest.approx(1000, rel=0.12)
    single = np.abs(np.angle(np.exp(1j * np.diff(towards)[jumps])))
    assert np.isin(
        single.round(6), [round(math.pi / 4, 6), 0.0, round(math.pi / 2, 6)]
    ).all()  # two in a tick now and then
    assert np.mean(np.isclose(single, math.pi / 4)) > 0.95
    assert 1.4 - 1e-9 <= strength.min() < 1.45 and 2.55 < strength.max() <= 2.6 + 1e-9


def test_a_draught_presses_on_the_closed_leaf_and_blows_through_the_open_door():
    gust = Gust(GustSection(draught=1.5), SHIPPED, 0)
    closed, ajar, wide = (gust.at(0.0, math.pi / 2 - opening) for opening in (0.0, 0.2, 1.2))
    assert closed.force == (0.0, 0.0, 0.0) and closed.hinge_torque == pytest.approx(-1.5 * 0.6)
    share = 2.0 * math.sin(0.1)
    np.testing.assert_allclose(ajar.force, [share * 1.5, 0.0, 0.0], atol=1e-12)
    assert ajar.hinge_torque == pytest.approx((share - 1.0) * 1.5 * 0.6)
    np.testing.assert_allclose(wide.force, [1.5, 0.0, 0.0], atol=1e-12)
    assert wide.hinge_torque == 0.0
