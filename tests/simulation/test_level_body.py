"""A fully actuated vehicle holds its place in wind with a level body: controller, allocation and rotors together."""

from __future__ import annotations

import math

import numpy as np

from doorman.control.position_controller import PositionController, Setpoint
from doorman.gravity import GRAVITY
from doorman.hardware.interface import Command
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.simulation import SimulatedBackend

WIND = {"simulation.gust.vehicle": 2.0, "simulation.gust.direction": math.pi / 2, "simulation.gust.variation": 0.0}


def test_a_level_body_holds_its_place_in_side_wind() -> None:
    model = Model(Scenario.load("push_tilted", WIND))
    vehicle, rest, still = model.vehicle, np.zeros(3), np.zeros(model.n_arm)
    controller = PositionController(vehicle.mass, GRAVITY, vehicle.max_thrust, model.scenario.control, model.actuation)
    off, tilt, last = [], [], 0.0
    with SimulatedBackend(model) as backend:
        measured = backend.read()
        place = backend.truth.position.copy()
        while measured.time < 8.0:
            hold = Setpoint(place, rest, rest, model.start_yaw, rest, rest, still)
            wanted = controller.update(measured.position, measured.velocity, hold, measured.time - last)
            last = measured.time
            ahead, left, up = model.actuation.body_force(wanted.force, measured.attitude)
            backend.command(Command(float(up), wanted.attitude, still, False, (float(ahead), float(left))))
            measured = backend.read()
            off.append(float(np.linalg.norm(backend.truth.position - place)))
            tilt.append(float(np.abs(backend.truth.attitude[:2]).max()))
    assert max(off[len(off) // 2 :]) < 0.02
    assert math.degrees(max(tilt)) < 1.0
