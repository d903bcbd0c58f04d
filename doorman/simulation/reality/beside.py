"""Joints of the door beside the one that a task moves: levers and leaves that swing on in the plant."""

from __future__ import annotations

from typing import Any

from doorman.kinematics.urdf.elements import link_name, read_parents
from doorman.model import Model
from doorman.scenario import BesideSection

_SOFT = 1e-3
"""Stiffness of a spring that only makes a preload [N m/rad]."""
_HARD = (0.999, 0.9999, 0.001, 0.5, 2.0)
"""Impedance of friction and stops, as MuJoCo has it."""
_HARD_TIME = 0.005
"""Time constant of a joint's friction: short, so that what friction holds does not creep [s]."""
_STOP_TIME = 0.02
"""Time constant of a stop, critically damped: a leaf that shuts at 1 rad/s goes 0.4° into its seal [s]."""


def touched_link(model: Model) -> str:
    """Link that the tip touches: the leaf, or the lever on it that was turned first."""
    urdf, contact, section = model.true_door.urdf, model.scenario.contact, model.scenario.door
    beside, parents = {each.joint for each in section.beside}, read_parents(urdf)
    at = contact.link or contact.frame
    while at is not None and at in parents:
        joint, parent = parents[at]
        if joint in beside:
            return at
        at = parent if joint != section.hinge else None
    return link_name(urdf, section.leaf)


def harden(joint: Any) -> None:
    """Give friction and stops of a joint little compliance."""
    joint.solref_friction, joint.solimp_friction = [_HARD_TIME, 1.0], list(_HARD)
    joint.solref_limit, joint.solimp_limit = [_STOP_TIME, 1.0], list(_HARD)


def set_beside(joint: Any, true: BesideSection) -> None:
    """Give another joint that moves its torques; a preload is that of a spring which is relaxed far from where the joint is."""
    joint.damping[0] = joint.damping[0] if true.damping is None else true.damping
    joint.frictionloss = joint.frictionloss if true.friction is None else true.friction
    harden(joint)
    stiffness = max(true.stiffness, _SOFT if true.preload > 0.0 else 0.0)
    lower, upper = joint.range
    opens = 1.0 if upper - true.closed > true.closed - lower else -1.0
    joint.stiffness[0] = stiffness
    joint.springref = true.closed - opens * true.preload / stiffness if stiffness > 0.0 else 0.0
