"""What is said of a vehicle in the end, by cameras and tilt: on the real links, in virtual time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from linked_rig import LinkedRig, until
from virtual_time import CLOCK

from doorman.flight import End, GuardedFlight
from doorman.hardware.pixhawk import LandedState
from doorman.hardware.safety import Fault
from doorman.recording import Recorder

SPEED = 0.8
"""At which a hand carries the vehicle [m/s]."""


@pytest.fixture(scope="module")
def linked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LinkedRig]:
    settings = {"pixhawk.setpoints": "position"}  # nothing is measured in hover
    with LinkedRig(tmp_path_factory.mktemp("rig"), links=settings) as made:
        yield made


@pytest.fixture
def flying(linked: LinkedRig) -> GuardedFlight:
    """At the hover point, with nothing to measure there."""
    linked.heal()
    flight = GuardedFlight(linked.model, linked.links, Recorder(None, {}))
    flight.begin()
    assert not flight.rise()
    return flight


def carry(rig: LinkedRig, *places: tuple[float, float, float]) -> None:
    """Let a hand carry the vehicle level from place to place, through an open door, and lay it down."""
    plant = rig.rig.plant
    data, travel = plant._simulator.plant.data, rig.model.travel
    with plant.lock:
        data.qpos[plant._simulator.plant.hinge_position] = rig.model.true_door.joint_value(travel.goal)
    for place in places:
        begin = rig.snapshot.truth.position
        way = np.asarray(place) - begin
        steps = max(1, round(float(np.linalg.norm(way)) / (0.01 * SPEED)))
        for step in range(steps):
            with plant.lock:
                phase = math.pi * (step + 1) / steps
                data.qpos[:3] = begin + 0.5 * (1.0 - math.cos(phase)) * way
                data.qvel[:3] = 0.5 * math.pi * math.sin(phase) / (0.01 * steps) * way
                data.qvel[3:6] = 0.0
            CLOCK.sleep(0.01)
    with plant.lock:
        data.qvel[:6] = 0.0


def over_the_sill(rig: LinkedRig) -> list[tuple[float, float, float]]:
    door = rig.model.door
    y = float(door.hinge_position[1]) + 0.6 * door.width
    return [(-1.0, y, 1.1), (-0.06, y, 1.1), (-0.06, y, 0.75)]


def test_a_landing_is_a_landing(flying: GuardedFlight) -> None:
    assert flying.descend() is End.LANDED
    assert not flying.seen


def test_a_vehicle_that_stays_armed_on_the_ground_is_disarmed_after_a_while(linked, flying):
    """It may only seem to stand, as on a gust: until then the autopilot's own word counts."""
    emulated = linked.rig.autopilot
    by_itself, emulated.parameters["COM_DISARM_LAND"] = emulated.parameters["COM_DISARM_LAND"], 60.0
    try:
        flying.supervisor.report(Fault.OPERATOR_LAND)
        until(lambda: linked.links.autopilot.state().landed is LandedState.ON_GROUND, "on the ground")
        begin = CLOCK.now()
        assert flying.descend() is End.LANDED
        assert 4.0 < CLOCK.now() - begin < 8.0
    finally:
        emulated.parameters["COM_DISARM_LAND"] = by_itself


def test_a_vehicle_that_came_down_by_itself_has_not_landed(linked, flying):
    emulated = linked.rig.autopilot
    x, y, z = (flying.places.pad + [0.0, 0.0, 0.01]).tolist()
    try:
        carry(linked, (x, y, z))
        emulated.kill_switch(True)
        assert flying.descend() is End.DROPPED, (flying.seen, flying.supervisor.findings)
    finally:
        emulated.kill_switch(False)


@pytest.mark.parametrize("heard", [True, False], ids=["motors stopped by radio", "link cut"])
def test_a_vehicle_on_the_sill_has_neither_landed_nor_is_it_landed(linked, flying, heard):
    emulated, plant = linked.rig.autopilot, linked.rig.plant
    gear = plant.gear
    if not heard:
        emulated.outgoing.cut = emulated.incoming.cut = True
    emulated.kill_switch(True)
    try:
        carry(linked, *over_the_sill(linked))
        plant.gear = replace(gear, length=gear.length + 0.4)  # the sill is as high, and bears the feet
        end = flying.descend()
        assert end is End.ON_SILL, (end, flying.seen, flying.supervisor.findings, linked.snapshot.truth.position)
        assert "in the doorway" in flying.seen
    finally:
        plant.gear = gear
        emulated.outgoing.cut = emulated.incoming.cut = False
        emulated.kill_switch(False)
