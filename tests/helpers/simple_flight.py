"""A recorded motion to draw: the quasi-static model under a simple law, the vehicle placed by the kinematic constraint."""

from __future__ import annotations

import math

import numpy as np
from attitude_matrices import body_rate_matrix
from paper_door import door_normal

from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.recording import Recorder, Recording


def opening_inputs(model: Model, state: np.ndarray) -> np.ndarray:
    """Pitch that accelerates the door towards the goal, yaw that follows the leaf, joints towards the goal's posture."""
    thrust = model.vehicle.mass * GRAVITY
    acceleration = 4.0 * (model.goal_angle - state[3]) - 4.0 * state[4]
    pitch = math.asin(
        np.clip(-acceleration * model.door.inertia / (model.coupling.distance_from_hinge * thrust), -0.2, 0.2)
    )
    error = np.array([-state[0], pitch - state[1], state[3] - math.pi / 2 - state[2]])
    body_rates = body_rate_matrix(state[:3]) @ (6.0 * error)
    return np.concatenate([[thrust], body_rates, np.clip(2.0 * (model.goal_state[5:] - state[5:]), -1.0, 1.0)])


def write_stretch(
    model: Model, recorder: Recorder, start: float, end: float, *, with_truth: bool = True, with_plan: bool = True
) -> None:
    """Record every topic of a flight between two times, with a plan five times a second."""
    step = model.scenario.planner.time_step
    state, offset = model.start_state.copy(), np.zeros(model.nx)
    offset[[1, 3]] = 0.004, -0.003  # estimates of pitch and door angle that are off by more than can be overlooked
    for k in range(round(end / step)):
        time = k * step
        inputs = opening_inputs(model, state)
        if time < start - 1e-9:
            state = model.step(state, inputs)
            continue
        if k in (0, 20):
            recorder.write("mission", time, {"state": ("open" if k else "touch"), "message": "as planned"})
        motion = model.coupling.vehicle_motion(state, inputs[1:4], inputs[4:])
        pose = {
            "position": motion.position, "velocity": motion.velocity, "attitude": state[:3], "body_rates": inputs[1:4],
            "arm_angles": state[5:], "arm_rates": inputs[4:],
        }  # fmt: skip
        force = inputs[0] * rotation_body_to_world(state[:3])[:, 2] - [0.0, 0.0, model.vehicle.mass * GRAVITY]
        if with_truth:
            normal = float(door_normal(state[3]) @ force)
            door = {"door_angle": state[3], "door_rate": state[4]}
            contact = {"tip_force": force, "tip_normal_force": normal, "touching": True, "collisions": 0}
            recorder.write("truth", time, pose | door | contact)
        recorder.write("measurement", time, pose)
        recorder.write("estimate", time, {"state": state + offset})
        recorder.write("command", time, {"thrust": inputs[0], "attitude": state[:3], "arm_rates": inputs[4:]})
        disturbance = np.array([math.sin(time), 0.5, -0.2])
        recorder.write("controller", time, {"disturbance": disturbance, "force": force, "saturated": False})
        if with_plan and k % 10 == 0:
            _write_plan(model, recorder, time, state)
        state = model.step(state, inputs)


def _write_plan(model: Model, recorder: Recorder, time: float, state: np.ndarray) -> None:
    states, inputs = [state], []
    for _ in range(model.scenario.planner.horizon_steps):
        inputs.append(opening_inputs(model, states[-1]))
        states.append(model.step(states[-1], inputs[-1]))
    solve_time = 0.002 if round(time) % 2 else 0.012  # some above the period of 0.01 s
    fields = {
        "state": state, "states": np.array(states), "input": inputs[0], "cost": 1.0, "max_violation": 0.0, "iterations": 2,
        "status": "solved", "solve_time": solve_time, "deadline_missed": solve_time > 0.01, "available_at": time + 0.01,
    }  # fmt: skip
    recorder.write("plan", time, fields)


def fly(model: Model, duration: float, **options: bool) -> Recording:
    """A flight in memory, from the start to its end."""
    recorder = Recorder(None, {"name": "paper"})
    write_stretch(model, recorder, 0.0, duration, **options)
    recorder.write("mission", duration, {"state": "end", "message": "flown to its end"})
    return recorder.recording()
