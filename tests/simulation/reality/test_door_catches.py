"""Seal, latch, lean and play of the true leaf, against statics and the motion of a rigid body."""

from __future__ import annotations

import math
from typing import Any

import pytest

from doorman.exceptions import ScenarioError
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.simulation import Disturbance, SimulatedBackend

FREE = {"contact__kind": "push", "away": True, "simulation__door_friction": 0.0, "simulation__door_damping": 0.0}
INERTIA = 5.28


def opened(flight: Any, torque: float, seconds: float, **true: Any) -> float:
    """How far 11 kg of leaf swing open under a torque [rad]."""
    source = lambda time: Disturbance(hinge_torque=-torque)  # noqa: E731
    plant = flight(disturbance=source, **{**FREE, **true})
    start = plant.plant.door_angle
    return float(start - plant.run(seconds, every=round(1e3 * seconds))[-1].door_angle)


def test_a_seal_holds_the_first_degrees_only(flight):
    assert opened(flight, 3.8, 0.5, simulation__door_seal=4.0) < 1e-3
    begun = opened(flight, 3.8, 0.5, simulation__door_seal=4.0, start__opening=0.05)
    assert begun == pytest.approx(0.5 * 3.8 / INERTIA * 0.25, rel=0.02)


def test_the_energy_that_a_seal_takes(flight):
    """Torque times angle, less seal times its angle, is what the leaf swings with."""
    seal, angle, torque = 3.0, math.radians(2.0), 4.0
    source = lambda time: Disturbance(hinge_torque=-torque)  # noqa: E731
    plant = flight(disturbance=source, simulation__door_seal=seal, **FREE)
    end = plant.run(1.2, every=1200)[-1]
    turned = math.pi / 2 - end.door_angle
    assert turned > angle
    assert 0.5 * INERTIA * end.door_rate**2 == pytest.approx(torque * turned - seal * angle, rel=0.03)


def test_a_latch_holds_until_it_snaps_and_catches_again(flight):
    latch = {"simulation__door_latch": 5.0}
    assert opened(flight, 2.0, 1.0, simulation__door_damping=100.0, **latch) == pytest.approx(0.01 * 2.0 / 5.0, rel=0.1)
    assert opened(flight, 6.0, 1.0, **latch) > 0.2
    source = lambda time: Disturbance(hinge_torque=0.0)  # noqa: E731
    ajar = flight(disturbance=source, start__opening=0.008, **{**FREE, "simulation__door_damping": 40.0}, **latch)
    assert math.pi / 2 - ajar.run(1.0, every=1000)[-1].door_angle < 0.002, "a leaf that is nearly shut is drawn shut"


@pytest.mark.parametrize("lean", [(0.01, 0.0), (-0.01, 0.0), (0.0, 0.02), (-0.006, -0.01)])
def test_a_leaf_on_a_leaning_hinge_falls_to_where_it_leans(flight, lean):
    """Closed, the shipped leaf lies along y and opens towards x: open by 0.5 rad, its normal is (cos 0.5, -sin 0.5)."""
    along_normal = lean[0] * math.cos(0.5) - lean[1] * math.sin(0.5)
    expected = 0.5 * 11.0 * 9.81 * 0.6 * along_normal / INERTIA * 0.25
    found = opened(flight, 0.0, 0.5, simulation__door_lean=lean, start__opening=0.5)
    assert found == pytest.approx(expected, rel=0.03, abs=2e-4)


def test_a_leaf_swings_freely_in_its_play_and_is_held_by_friction_at_its_end(flight):
    play = {"simulation__door_backlash": 0.04, "simulation__door_friction": 1.0}
    held = {**play, "simulation__door_damping": 60.0}
    assert opened(flight, 0.5, 4.0, **held) == pytest.approx(0.02 + 0.5e-3, abs=5e-4)
    assert opened(flight, 0.5, 4.0, **{**held, "simulation__door_backlash": 0.0}) < 1e-3
    moving = opened(flight, 3.0, 0.6, **play)
    assert 0.5 * 2.0 / INERTIA * 0.36 < moving < 0.5 * 3.0 / INERTIA * 0.36


def test_a_door_that_is_ajar_begins_so(model):
    with SimulatedBackend(model(mission__start="hover", simulation__door_ajar=0.2)) as backend:
        backend.read()
        assert backend.truth.door_angle == pytest.approx(math.pi / 2 - 0.2)


@pytest.mark.parametrize(("start", "opening"), [("contact", 0.1), ("hover", -1.0)])
def test_a_door_that_cannot_be_ajar_is_refused(model, start, opening):
    with pytest.raises(ScenarioError, match=r"simulation\.door_ajar") as caught:
        SimulatedBackend(model(mission__start=start, simulation__door_ajar=opening)).open()
    assert caught.value.allowed


def test_a_slide_does_not_lean() -> None:
    with pytest.raises(ScenarioError, match=r"simulation\.door_lean"):
        SimulatedBackend(Model(Scenario.load("drawer", {"simulation.door_lean": (0.01, 0.0)}))).open()
