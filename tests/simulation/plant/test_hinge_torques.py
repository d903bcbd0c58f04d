"""Preload and stiction of the simulated hinge, against statics and the motion of a rigid leaf."""

from __future__ import annotations

import math
from typing import Any

import pytest

from doorman.model import Model
from doorman.scenario import Scenario
from doorman.simulation.simulator import Disturbance, Simulator

STEP = 1e-3


def simulator(torque: float, **simulation: Any) -> Simulator:
    """The handled door, half open, with a torque on it [N m]; the vehicle hovers elsewhere."""
    keys = {f"simulation.{name}": value for name, value in simulation.items()}
    start = {"start.opening": 0.8, "mission.hover_distance": 1.5}
    model = Model(Scenario.load("shipped:close", {**start, "simulation.door_damping": 0.0, **keys}))
    return Simulator(model, STEP, lambda time: Disturbance(hinge_torque=torque))


def turned(plant: Simulator, seconds: float) -> float:
    """By how much the opening changes [rad]."""
    door = plant.model.true_door
    before = door.opening_of(plant.plant.door_angle)
    plant.advance(round(seconds / STEP))
    return float(door.opening_of(plant.plant.door_angle) - before)


def test_a_preload_shuts_the_door_as_its_torque_says() -> None:
    plant = simulator(0.0, door_preload=2.0, door_friction=0.0)
    inertia = plant.model.true_door.inertia
    assert turned(plant, 0.5) == pytest.approx(-0.5 * 2.0 / inertia * 0.25, rel=0.02)


def test_a_door_with_a_preload_stops_where_it_is_closed() -> None:
    plant = simulator(0.0, door_preload=4.0, door_friction=0.0)
    turned(plant, 4.0)
    assert abs(plant.model.true_door.opening_of(plant.plant.door_angle)) < math.radians(0.5)


@pytest.mark.parametrize(("torque", "moves"), [(1.3, False), (1.7, True)])
def test_a_standing_hinge_needs_friction_and_stiction_overcome(torque: float, moves: bool) -> None:
    plant = simulator(torque, door_friction=0.5, door_stiction=1.0)
    inertia = plant.model.true_door.inertia
    expected = 0.5 * (torque - 0.5) / inertia * 0.25 if moves else 0.0
    assert turned(plant, 0.5) == pytest.approx(expected, rel=0.1, abs=2e-4)
