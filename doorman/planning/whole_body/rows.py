"""What a whole-body plan keeps to and what it is drawn to, from the expressions of its task."""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.collision.constraints import collision_constraints, disc_constraints
from doorman.collision.rows.listed import ARM, IN_A_DOORWAY, Kinds
from doorman.kinematics.scale import Scale
from doorman.ocp.problem.terms import Constraint, Residual
from doorman.planning.pace import rate_to_goal
from doorman.planning.vehicle_rows import rotor_thrusts, static_moment
from doorman.planning.whole_body.task import WholeBodyTask

_FORCE = 30.0
"""Excess of the tip's force that counts as much as a metre: about the shipped vehicle's weight [N]."""
_ROUNDED_FORCE, _ROUNDED_ROOM = 0.2, 0.01
"""Over which corners of the cost are rounded, for the shipped vehicle [N], [m]."""


def constraints(task: WholeBodyTask, kinds: Kinds = IN_A_DOORWAY) -> list[Constraint]:
    """Hard limits on states. A measured pose moves the disc across a row by its noise: its margin is soft, see `residuals`.

    The leaf's speed has no row: nothing that a pushing tip does keeps a leaf slow that something else drives.
    """
    limits, force = task.limits, ca.sqrt(task.spring_force**2 + _ROUNDED_FORCE**2)  # its size, rounded
    return [
        *static_moment(task),
        *collision_constraints(task, limits.margin, (ARM,)),
        *disc_constraints(task, 0.0, kinds),
        Constraint("tip presses or pulls too hard", force - limits.force, "N", _FORCE),
        *rotor_thrusts(task),
    ]


def residuals(task: WholeBodyTask, kinds: Kinds = IN_A_DOORWAY) -> list[Residual]:
    """Residuals that a plan keeps small; one of weight 0 counts for nothing."""
    goes, weigh, free = task.reference, task.weights, 1 - task.touches
    scale = Scale.of(task.vehicle.radius, task.vehicle.mass)
    force, room = _ROUNDED_FORCE * scale.force, _ROUNDED_ROOM * scale.length
    off_goal = task.door_angle - goes.joint
    approach = goes.approach_speed * ca.tanh((goes.depth - task.depth) / goes.approach_length)
    opening = rate_to_goal(task.to_go, goes.opening_speed, goes.deceleration, goes.settling)
    sides = getattr(task, "actuation", None)
    side = [] if sides is None else [Residual("side force", task.side_force - sides.side, sides.side_weight)]
    planes = ca.vertcat(*(row.expression for row in disc_constraints(task, task.limits.margin, kinds)))
    return [
        *side,
        Residual("level", task.attitude[:2], weigh.level),
        Residual("thrust", task.thrust - goes.thrust, weigh.thrust),
        Residual("place on the face", task.place, weigh.place),
        Residual("place in the world", task.position - goes.position, weigh.position),
        Residual("heading", task.attitude[2] - goes.heading[0] - goes.heading[1] * off_goal, weigh.heading),
        Residual("arm", task.arm_angles - goes.arm - goes.arm_slope * off_goal, weigh.arm),
        Residual("arm rate", task.arm_rates - goes.arm_slope * task.door_rate, weigh.arm_rate),
        Residual("approach", free * (task.closing_speed - approach), weigh.approach),
        Residual("opening", task.rate_to_goal - opening, weigh.opening),
        Residual("force", task.normal_force - goes.force, weigh.force),
        Residual("least force", _positive(goes.least_force - task.normal_force, force), weigh.least_force),
        Residual("load of the gripper", task.force_in_face, weigh.load),
        Residual("near a plane", _positive(planes + goes.room, room), weigh.near),
        Residual("tilting", task.tilt_command + goes.turned - task.attitude[:2], weigh.tilting),
        Residual("velocity in the world", task.velocity, weigh.velocity_in_world),
        Residual("turning", task.attitude_rates[2] - goes.heading[1] * task.door_rate, weigh.turning),
    ]  # fmt: skip


def _positive(value: Any, rounding: Any) -> Any:
    """max(0, ·), rounded."""
    return 0.5 * (value + ca.sqrt(value**2 + rounding**2))
