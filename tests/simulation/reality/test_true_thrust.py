"""Thrust that is not what is commanded: its scale, its fall, and what floor and ceiling add, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.exceptions import ScenarioError
from doorman.scenario import SimulationSection
from doorman.simulation.reality.true_thrust import ceiling_effect, ground_effect

HOVER = 3.0 * 9.81


def climbed(flight, seconds: float, **true) -> float:
    """Vertical speed after so long at the believed hover thrust [m/s]."""
    return float(
        flight(contact__kind="push", away=True, **true).run(seconds, every=round(1e3 * seconds))[-1].velocity[2]
    )


@pytest.mark.parametrize("scale", [0.85, 1.1])
def test_thrust_is_scaled(flight, scale):
    assert climbed(flight, 0.2, simulation__thrust_scale=scale) == pytest.approx((scale - 1.0) * 9.81 * 0.2, rel=0.02)
    truth = flight(contact__kind="push", away=True, simulation__thrust_scale=scale).run(0.01)[-1]
    assert truth.rotor_thrusts.sum() == pytest.approx(scale * HOVER, rel=1e-3)


def test_thrust_falls_by_a_share_a_second(flight):
    fall, time = 0.05, 0.4
    expected = 9.81 * ((1.0 - math.exp(-fall * time)) / fall - time)
    assert climbed(flight, time, simulation__thrust_fall=fall) == pytest.approx(expected, rel=0.05)


def test_drag_torque_goes_with_the_thrust(flight):
    vehicle = flight(contact__kind="push", away=True, simulation__thrust_scale=0.8)
    vehicle.run(0.002)
    gears = vehicle.plant.engine_model.actuator_gear[:6]
    np.testing.assert_allclose(gears[:, 2], 0.8)
    np.testing.assert_allclose(np.abs(gears[:, 5]), 0.8 * 0.016)
    vehicle.simulator.set_rotors(np.full(6, 5.0), np.ones(6))
    vehicle.run(0.002)
    np.testing.assert_allclose(gears[:, 5], -0.8 * 0.016)


def test_floor_and_ceiling_follow_their_papers():
    """Cheeseman and Bennett at one radius: 1/(1 - 1/16). Hsiao and Chirarattananon: no effect far off."""
    assert ground_effect(np.array(1.0)) == pytest.approx(16.0 / 15.0)
    assert ground_effect(np.array(0.25)) == pytest.approx(1.0, abs=0.005)
    assert ceiling_effect(np.array(1e-6)) == pytest.approx(1.0)
    gamma = float(ceiling_effect(np.array(2.0))) ** 1.5  # by its definition: flow and momentum below a ceiling
    assert gamma**2 - gamma == pytest.approx(4.0 / 32.0)


def test_near_floor_and_ceiling_the_vehicle_rises(flight):
    near = {"contact__kind": "push", "away": True}
    plain = flight(**near, simulation__wash__ground=True)
    height = float(plain.data.site("rotor_1").xpos[2])
    far = plain.run(0.2, every=200)[-1].velocity[2]
    low = flight(**near, simulation__wash__ground=True)
    low.data.qpos[2] -= height - 0.15
    below = flight(**near, simulation__wash__ceiling=height + 0.1)
    lift = [float(one.run(0.2, every=200)[-1].velocity[2]) for one in (low, below)]
    assert abs(far) < 0.01 and min(lift) > 0.03


def test_a_thrust_of_nothing_is_refused():
    with pytest.raises(ScenarioError, match=r"thrust_scale.*0\.2"):
        SimulationSection(thrust_scale=0.0)
    with pytest.raises(ScenarioError, match="thrust_fall"):
        SimulationSection(thrust_fall=-0.1)
