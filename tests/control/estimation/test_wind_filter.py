"""Wind whose truth is known: in free flight it is measured, in contact it is told from what the hinge resists with."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.control.estimation.wind_filter import WindFilter

Array = np.ndarray
TICK = 0.004
LEVERS = (0.7, 0.25)


def turning(time: float, rate: float, strength: float = 1.0) -> Array:
    return strength * np.array([math.cos(0.4 + rate * time), math.sin(0.4 + rate * time), 0.0])


def flown(rate: float, strength: float = 1.0, seed: int = 3) -> WindFilter:
    """After 7 s of free flight, with what a noisy observer feels."""
    wind, noise, generator = WindFilter(), np.zeros(3), np.random.default_rng(seed)
    for k in range(round(7.0 / TICK)):
        noise = noise + TICK / 0.2 * (-noise + 0.7 * generator.standard_normal(3))
        wind.predict(TICK)
        wind.feel(turning(k * TICK, rate, strength) + noise, near=False, time_step=TICK)
    return wind


@pytest.mark.parametrize("rate", [-0.157, 0.08])
def test_wind_that_turned_in_free_flight_goes_on_turning_in_contact(rate: float) -> None:
    wind = flown(rate)
    for _ in range(round(12.0 / TICK)):
        wind.predict(TICK)
    assert np.linalg.norm(wind.force - turning(19.0, rate)) < 0.45
    assert np.linalg.norm(turning(19.0, rate) - turning(7.0, rate)) > 0.9  # what a wind that stays would be wrong by


def test_still_air_stays_still_while_a_closer_winds_up() -> None:
    wind, normal = flown(0.0, strength=0.0), np.array([1.0, 0.0, 0.0])
    for k in range(round(12.0 / TICK)):
        wind.predict(TICK)
        wind.pushed(normal, LEVERS, 0.8 + 1.8 * 0.1 * k * TICK, 0.1, TICK)
    assert np.linalg.norm(wind.force) < 0.25
    assert wind.state[4] == pytest.approx(0.8 + 1.8 * 1.2, abs=0.4)


def test_a_closer_that_is_known_winds_up_without_passing_for_wind_that_may_turn() -> None:
    normal, off = np.array([1.0, 0.0, 0.0]), []
    for closer in (0.0, 1.8):
        wind = flown(0.08)
        wind.covariance[3, 3] += 0.05**2  # how it turns is less certain than after a long hover
        for k in range(round(12.0 / TICK)):
            wind.predict(TICK)
            torque = 0.8 + 1.8 * 0.1 * k * TICK - sum(LEVERS) * turning(7.0 + k * TICK, 0.08)[0]
            wind.pushed(normal, LEVERS, torque, 0.1, TICK, closer)
        off.append(abs(float(wind.force[0] - turning(19.0, 0.08)[0])))
    assert off[1] < 0.3 < off[0]


def test_a_leaf_that_creeps_on_under_less_push_than_it_needed_here_is_in_wind() -> None:
    wind, normal = flown(0.0, strength=0.5), np.array([0.0, 1.0, 0.0])
    before = normal @ wind.force
    for k in range(round(4.0 / TICK)):
        wind.predict(TICK)
        wind.pushed(normal, LEVERS, 1.2 - sum(LEVERS) * before, 0.1, TICK)
    for k in range(round(12.0 / TICK)):
        blows = before + min(0.1 * k * TICK, 0.8)
        wind.predict(TICK)
        wind.pushed(normal, LEVERS, 1.2 - sum(LEVERS) * blows, 0.015, TICK)
    assert normal @ wind.force - before > 0.4


def test_a_leaf_that_stands_says_no_more_than_that_it_bears_the_push() -> None:
    wind, normal = flown(0.0, strength=0.5), np.array([0.0, 1.0, 0.0])
    before = wind.state.copy()
    for _ in range(500):
        wind.pushed(normal, LEVERS, 0.1, 0.0, TICK)
    np.testing.assert_array_equal(wind.state, before)
    for _ in range(500):
        wind.pushed(normal, LEVERS, 3.0, 0.0, TICK)
    assert wind.state[4] > 2.5


def test_what_no_contact_explains_is_wind_and_what_is_found_suddenly_is_believed_in_part() -> None:
    wind, aside = flown(0.0, strength=0.5), np.array([0.0, 0.0, 1.0])
    before = wind.force
    for _ in range(round(8.0 / TICK)):
        wind.predict(TICK)
        wind.unexplained(aside, -0.6 - float(aside @ (before - wind.force)), TICK)
    assert 0.4 < aside @ (wind.force - before) < 0.7
    wind = flown(0.0, strength=0.5)
    wind.lost(wind.force + np.array([3.0, 0.0, 0.0]))
    assert before[0] + 1.0 < wind.force[0] < before[0] + 2.0


def test_with_a_smaller_vehicle_and_leaf_the_same_wind_is_found_in_their_units() -> None:
    """Forces × 1/8, lengths × 1/2: wind changes by as much of the weight."""
    normal, found = np.array([0.8, 0.6, 0.0]), []
    for force, length in ((1.0, 1.0), (0.125, 0.5)):
        torque = force * length
        wind = WindFilter(force, torque)
        for k in range(500):
            wind.predict(TICK)
            wind.feel(force * turning(k * TICK, 0.1, 0.5), near=k > 400, time_step=TICK)
        wind.met(normal, 0.2 * force)
        for _ in range(500):
            wind.predict(TICK)
            wind.unexplained(normal, 0.1 * force, TICK)
            wind.pushed(normal, (length * LEVERS[0], length * LEVERS[1]), 0.5 * torque, 0.1, TICK)
        units = np.array([force, force, force, 1.0, torque])
        found.append((wind.state / units, wind.covariance / np.outer(units, units)))
    np.testing.assert_allclose(found[1][0], found[0][0], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found[1][1], found[0][1], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("offset", [0.0, 0.3])
def test_a_reading_of_the_tip_s_force_tells_the_wind_along_the_normal_as_well_as_its_offset_is_known(
    offset: float,
) -> None:
    wind, normal = flown(0.0, strength=0.5), np.array([0.6, 0.8, 0.0])
    random = np.random.default_rng(2)
    for _ in range(round(30.0 / TICK)):
        wind.predict(TICK)
        wind.pressed(normal, 1.1 + 0.05 * float(random.standard_normal()), 0.05**2, offset**2, TICK)
    doubt = math.sqrt(float(normal @ wind.covariance[:3, :3] @ normal))
    assert abs(float(normal @ wind.force) - 1.1) < max(0.1, 1.5 * offset)
    assert doubt == pytest.approx(max(offset, 0.06), rel=0.35)
