"""Dead time of the simulated attitude loop, and the link by which commands reach it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.model import Model
from doorman.scenario import Scenario
from doorman.signals import Command
from doorman.simulation import SimulatedBackend, Simulator
from doorman.simulation.delay_line import DelayLine

HOVER = {"mission.start": "hover"}


def first_turn(dead_time: float, **settings: float) -> float:
    """Time until the pitch of a hovering vehicle begins to follow a step of its command [s]."""
    keys = {f"simulation.{key}": value for key, value in settings.items()}
    model = Model(Scenario.load("push", {**HOVER, "simulation.attitude_dead_time": dead_time, **keys}))
    backend = SimulatedBackend(model, seed=3)
    backend.open()
    backend.read()
    start = backend.truth.attitude
    level = Command(model.vehicle.mass * 9.81, start, np.zeros(model.n_arm))
    backend.command(level)
    for _ in range(50):
        backend.read()
        backend.command(level)
    begun = backend.truth.time
    tilted = Command(level.thrust, start + [0.0, 0.1, 0.0], level.arm_rates)
    while abs(backend.truth.attitude[1] - start[1]) < 0.002 and backend.truth.time < begun + 1.0:
        backend.command(tilted)
        backend.read()
    backend.stop()
    return backend.truth.time - begun


def test_the_attitude_waits_for_its_dead_time() -> None:
    assert first_turn(0.08) - first_turn(0.0) == pytest.approx(0.08, abs=0.005)


def test_commands_that_are_taken_rarely_and_late_come_later() -> None:
    assert first_turn(0.0, command_rate=20.0, command_jitter=0.02) > first_turn(0.0) + 0.004


def test_thrust_has_no_dead_time() -> None:
    model = Model(Scenario.load("push", {**HOVER, "simulation.attitude_dead_time": 0.1}))
    simulator = Simulator(model, 1e-3)
    simulator.set_command(0.5 * model.vehicle.mass * 9.81, model.start_state[:3], np.zeros(model.n_arm))
    simulator.advance(90)
    assert simulator.truth().velocity[2] < -0.1


def test_link_takes_so_many_a_second_and_keeps_their_order() -> None:
    link, taken = DelayLine[int](0.0, 0.03, 50.0, 1), []
    for tick in range(1000):
        now = 0.004 * tick
        link.send(now, tick)
        if (one := link.arrived(now)) is not None:
            taken.append((now, one))
    ages = np.array([now - 0.004 * one for now, one in taken])
    assert [one for _, one in taken] == sorted({one for _, one in taken})
    assert len(taken) <= 4.0 * 50.0 + 1 and ages.min() >= -1e-9 and ages.max() < 0.03 + 0.005 and ages.std() > 0.003
    plain = DelayLine[int](seed=1)
    plain.send(0.0, 7)
    assert plain.is_plain and plain.arrived(0.0) == 7 and plain.arrived(math.inf) is None


def test_what_is_on_its_way_goes_on_by_another_clock() -> None:
    link = DelayLine[int](0.5)
    link.send(3.0, 7)
    other = link.shifted(2.0)
    assert (other.due, link.due) == (1.5, 3.5) and other.arrived(1.5) == 7
