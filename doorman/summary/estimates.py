"""What was estimated in a run beside what is true: the hinge, the place of the door, and its angle."""

from __future__ import annotations

import math

import numpy as np

from doorman.model import Model
from doorman.recording import Recording


def estimates(recording: Recording, model: Model) -> dict[str, dict[str, float]]:
    """Parameters of the hinge and the door's place, as estimated at the end, and its angle where the frame was touched."""
    estimate, simulation, door = recording["estimate"], model.scenario.simulation, model.true_door
    arm = door.per_angle
    mass = 1.0 if simulation.door_mass is None else simulation.door_mass / door.mass
    rest = door.rest_angle if simulation.door_rest_angle is None else simulation.door_rest_angle
    true = {
        "damping": door.damping if simulation.door_damping is None else arm**2 * simulation.door_damping,
        "friction": door.friction if simulation.door_friction is None else arm * simulation.door_friction,
        "stiffness": door.stiffness if simulation.door_stiffness is None else arm**2 * simulation.door_stiffness,
        "inertia": door.inertia * mass,
    }
    found = {
        name: {"value": float(estimate["hinge"][-1, i]), "deviation": float(estimate["hinge_deviation"][-1, i]),
               "true": float(value)}
        for i, (name, value) in enumerate(true.items())
    }  # fmt: skip
    angle = float(recording["truth"]["door_angle"][-1])
    turned = model.start_angle - angle
    found["torque"] = {
        "value": found["friction"]["value"] + found["stiffness"]["value"] * turned,
        "deviation": float(estimate["torque_deviation"][-1]),
        "true": true["friction"] + true["stiffness"] * (rest - angle) + _preload(model) + _leaning(model, angle),
    }
    linear = ("friction", "torque")
    found = {name: _in_joint(figures, 1 if name in linear else 2, arm) for name, figures in found.items()}
    if door.vertical and "door_place" in estimate:
        found |= _place(recording, model)
    return found | _measured_angle(recording)


def _measured_angle(recording: Recording) -> dict[str, dict[str, float]]:
    """The door's angle as the tip measured it last; a door that is left may move on."""
    estimate, truth = recording["estimate"], recording["truth"]
    if "door_angle_deviation" not in estimate:
        return {}
    measured = np.flatnonzero(np.isfinite(estimate["door_angle_deviation"][: len(truth.time)]))
    if not len(measured):
        return {}
    value, deviation = estimate["state"][measured[-1], 3], estimate["door_angle_deviation"][measured[-1]]
    true = truth["door_angle"][measured[-1]]
    return {"door_angle": {"value": float(value), "deviation": float(deviation), "true": float(true)}}


def _preload(model: Model) -> float:
    """Torque of the true closer's preload beyond the one that the scenario names, against falling α [N m]."""
    door, true = model.true_door, model.scenario.simulation.door_preload
    beyond = 0.0 if true is None else true - model.door.section.preload
    return -door.torque_of_closer(door.per_angle * beyond)


def _leaning(model: Model, angle: float) -> float:
    """Torque of the true leaf's weight where its hinge leans, against falling α [N m]."""
    simulation, door = model.scenario.simulation, model.true_door
    weight = float(door.weight[0]) * (1.0 if simulation.door_mass is None else simulation.door_mass / door.mass)
    return -weight * float(np.array([*simulation.door_lean, 0.0]) @ door.normal(angle))


def _place(recording: Recording, model: Model) -> dict[str, dict[str, float]]:
    """Where the door stands against the map, as estimated at the end, and in truth."""
    estimate, simulation = recording["estimate"], model.scenario.simulation
    true = (*simulation.door_offset[:2], simulation.door_yaw)
    return {
        name: {"value": float(estimate["door_place"][-1, i]), "deviation": float(estimate["door_place_deviation"][-1, i]),
               "true": float(true[i])}
        for i, name in enumerate(("door_x", "door_y", "door_yaw"))
    }  # fmt: skip


def _in_joint(figures: dict[str, float], power: int, per_angle: float) -> dict[str, float]:
    """Figures of the URDF's joint: newtons and kilograms of a slide."""
    return figures if per_angle == 1.0 else {name: value / per_angle**power for name, value in figures.items()}


def largest_angle_error(recording: Recording) -> float:
    """Largest difference of the door's estimated angle from the true one [deg]."""
    truth, estimate = recording["truth"], recording["estimate"]
    count = min(len(truth.time), len(estimate.time))
    error = estimate["state"][:count, 3] - truth["door_angle"][:count]
    return math.degrees(float(np.abs((error + math.pi) % (2 * math.pi) - math.pi).max()))
