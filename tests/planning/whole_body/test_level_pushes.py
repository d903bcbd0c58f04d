"""Pushes with a level body: what plans ask of the rotors lies in their polytope, and uses it."""

from __future__ import annotations

import numpy as np
import pytest

from doorman import Model, Planner
from doorman.kinematics.vehicles.rotor_layout import rotor_layout


@pytest.mark.slow  # compiles for more than a minute
@pytest.mark.parametrize(("wind", "least"), [(2.5, 2.3), (4.0, 3.0)])
def test_a_plan_pushes_against_wind_with_all_that_the_rotors_have(wind: float, least: float) -> None:
    """Wind and push need more than a box inside the polytope holds, and with the second wind more than all of it."""
    model = Model("push_tilted")
    planner = Planner(model)
    planner.update_door(friction=0.0, disturbance=-0.5)
    planner.update_numbers({"vehicle.wind": [-wind, 0.0, 0.0]})
    plan = planner.plan(planner.planning.start_state)
    layout = rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust)
    forces = np.column_stack([plan.inputs[:, 0], plan.inputs[:, -2:]])
    thrusts = forces[:, :1] * layout.inverse[:, 0] + forces[:, 1:] @ layout.side_inverse.T
    kept = 0.08 * layout.max_thrusts
    assert (thrusts > kept - 0.05).all() and (thrusts < layout.max_thrusts - kept + 0.05).all()
    assert plan.inputs[:, -2].max() > least
