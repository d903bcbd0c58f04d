"""A collision told by forces, tilt and height: what bears a vehicle that flies."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from doorman.flight.ends import CarriedWatch
from doorman.gravity import GRAVITY
from doorman.hardware.pixhawk import VehicleSample
from doorman.hardware.safety import Observation
from doorman.hardware.safety.observer import ForceEstimator

MASS = 3.0
SEEN = Observation(now=0.0, position=np.array([0.0, 0.6, 0.52]), tilt=math.radians(12.0), speed=0.0)
PERIOD = 0.02


def told(thrust_share: float, acceleration: float = 0.0, seconds: float = 1.5, holds: bool = False) -> str:
    """Of a vehicle whose rotors lift this share of its weight, and that accelerates upwards so."""
    watch, force = CarriedWatch(), ForceEstimator(MASS)
    for tick in range(round(seconds / PERIOD)):
        now = tick * PERIOD
        sample = VehicleSample(
            velocity=np.array([0.0, 0.0, acceleration * now]), attitude=np.zeros(3), position_time=now
        )
        force.update(sample, thrust_share * MASS * GRAVITY)
        watch.note(replace(SEEN, now=now, lift=force.lift), holds)
    return watch.words


def test_a_sill_that_bears_the_vehicle_is_told_with_place_and_tilt() -> None:
    words = told(thrust_share=0.4)
    assert "0.52 m" in words and "12°" in words


def test_flight_and_fall_are_no_collision() -> None:
    assert not told(1.0)
    assert not told(0.4, acceleration=-0.6 * GRAVITY), "it falls as its thrust says"
    assert not told(1.2, acceleration=-1.0), "something presses it down"
    assert not told(0.85), "the friction of a tip that pushes"


def test_a_blow_and_a_leaf_that_is_held_are_none() -> None:
    assert not told(0.4, seconds=0.3)
    assert not told(0.4, holds=True)


def test_what_is_not_known_is_no_force() -> None:
    watch = CarriedWatch()
    for tick in range(100):
        watch.note(replace(SEEN, now=tick * PERIOD, lift=math.nan), holds=False)
    assert not watch.words
