"""What moves a free leaf, and what holds it: the true torques of a simulated joint where they are given."""

from __future__ import annotations

from doorman.model import Model


def torques_at_rest(model: Model, door_angle: float) -> tuple[float, float]:
    """Torque of weight, closer and spring on a leaf at rest, and the friction against it."""
    door, true = model.true_door, model.scenario.simulation
    arm, section = door.per_angle, model.door.section
    friction = door.friction if true.door_friction is None else arm * true.door_friction
    friction += door.stiction if true.door_stiction is None else arm * true.door_stiction
    preload = arm * (section.preload if true.door_preload is None else true.door_preload)
    stiffness = door.stiffness if true.door_stiffness is None else arm**2 * true.door_stiffness
    rest = door.rest_angle if true.door_rest_angle is None else true.door_rest_angle
    spring = stiffness * (door_angle - rest)
    return door.weight_torque(door_angle) + door.torque_of_closer(preload) + spring, friction
