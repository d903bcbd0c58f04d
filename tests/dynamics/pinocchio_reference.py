"""Pinocchio's constrained dynamics of the free-flying vehicle tied to the door at the tip: an independent second opinion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio
from lagrangian_in_numbers import LagrangianModel, rotation_jacobian, translation_jacobian
from numpy.typing import NDArray

from doorman.kinematics.rotations import rotation_body_to_world

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Reference:
    """What Pinocchio says at one state."""

    body_acceleration: Array
    """Ω̇, shape (3,)."""
    door_acceleration: float
    force_on_door: Array
    """At the tip, shape (3,), world frame."""


def constrained_dynamics(model: LagrangianModel, state: Array, inputs: Array) -> Reference:
    """Accelerations and contact force of vehicle and door from their URDFs, the arm's joints locked at H."""
    coupling = model.coupling
    flying = _locked_vehicle(model, state[8:])
    tied, root = flying.copy(), 1
    hinge = tied.addJoint(0, pinocchio.JointModelRZ(), coupling.door.model.jointPlacements[1], "hinge")
    tied.appendBodyToJoint(hinge, coupling.door.model.inertias[1], pinocchio.SE3.Identity())
    tip_frame = flying.getFrameId(coupling.vehicle.names.tip, pinocchio.FrameType.BODY)
    tip = pinocchio.SE3(np.eye(3), flying.frames[tip_frame].placement.translation)
    leaf = pinocchio.SE3(np.eye(3), np.array([coupling.distance_from_hinge, 0.0, coupling.height]))
    tie = pinocchio.RigidConstraintModel(
        pinocchio.ContactType.CONTACT_3D, tied, root, tip, hinge, leaf, pinocchio.ReferenceFrame.LOCAL
    )
    ties, tie_data, data = [tie], [tie.createData()], tied.createData()
    pinocchio.initConstraintDynamics(tied, data, ties, tie_data)
    position, velocity, force = _configuration(model, state, inputs)
    acceleration = pinocchio.constraintDynamics(tied, data, position, velocity, force, ties, tie_data)
    rotation = rotation_body_to_world(state[:3])
    return Reference(acceleration[3:6].copy(), float(acceleration[6]), -rotation @ data.lambda_c)


def _locked_vehicle(model: LagrangianModel, arm_angles: Array) -> pinocchio.Model:
    vehicle = model.coupling.vehicle
    free = pinocchio.buildModelFromUrdf(str(vehicle.urdf), pinocchio.JointModelFreeFlyer())
    position = pinocchio.neutral(free)
    position[7:] = arm_angles
    locked = [free.getJointId(name) for name in vehicle.joint_names]
    return pinocchio.buildReducedModel(free, locked, position)


def _configuration(model: LagrangianModel, state: Array, inputs: Array) -> tuple[Array, Array, Array]:
    """Position, velocity (both on the constraint) and generalised force: thrust and torque on the body, torque in the hinge."""
    coupling, q, q_rate = model.coupling, state[:4], state[4:8]
    rotation = rotation_body_to_world(q[:3])
    place = pinocchio.SE3(rotation, coupling.vehicle_position(q[:3], q[3], state[8:]))
    linear = rotation.T @ translation_jacobian(coupling, q[:3], q[3], state[8:]) @ q_rate
    angular = rotation_jacobian(q[:3]) @ q_rate
    hinge = -coupling.door.hinge_torque(q[3], q_rate[3]) - model.disturbance
    force = np.concatenate([[0.0, 0.0], inputs[:4], [hinge]])
    return (
        np.concatenate([pinocchio.SE3ToXYZQUAT(place), q[3:]]),
        np.concatenate([linear, angular, q_rate[3:]]),
        force,
    )
