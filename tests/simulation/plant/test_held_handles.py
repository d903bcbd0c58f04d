"""A gripper on what turns easily: its tie is as stiff as the physics' steps resolve, and throws nothing."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.model import Model
from doorman.scenario import Scenario
from doorman.simulation.simulator import Disturbance, Simulator

SLIDES = 0.4
"""Against 0.25 N m of friction and what the tip holds [N m]."""


@pytest.mark.parametrize("mass", [None, 0.05])
def test_a_light_handle_is_not_thrown(mass: float | None) -> None:
    """A torque moves the handle against the hovering vehicle's tip: no force is far above what it takes to hold that."""
    keys = {"mission.start": "contact", "simulation.door_mass": mass}
    model = Model(Scenario.load("knob_valve", {key: value for key, value in keys.items() if value is not None}))
    simulator = Simulator(model, 0.001, lambda _: Disturbance(hinge_torque=model.travel.sense * SLIDES))
    simulator.set_grip(True)
    simulator.set_command(model.vehicle.weight, (0.0, 0.0, model.start_yaw), np.zeros(model.n_arm))
    forces, rates = [], []
    for _ in range(100):
        simulator.advance(3)
        truth = simulator.truth()
        forces.append(float(np.linalg.norm(truth.tip_force)))
        rates.append(abs(truth.door_rate))
    assert max(forces) < 10.0 * SLIDES / model.coupling.lever_length
    assert max(rates) < 2.0
