r"""The vocabulary of a door task in symbols: what dynamics, constraints, costs and filters are written with.

Every task has the names of `NAMES`, whatever its states are. In a `TiedTask` the tip is tied to the contact point, in
`WholeBodyTask` the vehicle flies freely. The geometry of the leaf is `leaf_symbols`'.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType, SimpleNamespace
from typing import Any

import casadi as ca

from doorman.gravity import weight_of
from doorman.kinematics.doors.leaf.leaf_motion import CLOSED
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.symbols import SymbolicBodies, arm_points, rotation_body_to_world
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern

NAMES: Mapping[str, str] = MappingProxyType({
    "time": "time of the node [s]: since the plan's first node, plus `planner.update_time(…)`",
    "position": "place of the vehicle's body frame [m]",
    "velocity": "its velocity [m/s]",
    "attitude": "roll, pitch and yaw of the vehicle [rad]",
    "rotation": "rotation matrix, body to world",
    "body_rates": "body rates in body axes [rad/s]",
    "door_angle": "angle α of the door, π/2 where it is closed [rad]",
    "door_rate": "its rate [rad/s]",
    "opening": "how far the door is open, 0 where it is closed [rad, m of a slide]",
    "opening_rate": "rate of `opening`, positive while the door opens [rad/s, m/s of a slide]",
    "joint": "value of the URDF's joint of the door [rad or m]",
    "arm_angles": "values of the arm's joints [rad, m of a slide]",
    "arm_rates": "their rates, inputs [rad/s, m/s of a slide]",
    "tip_position": "place of the arm's tip [m]",
    "points": 'places of the arm\'s points by name, such as `points["tip"]` [m]',
    "points_in_body": "the same in body axes, from the body frame [m]",
    "contact_point": "point of the leaf that the tip is to touch [m]",
    "contact_normal": "normal of the leaf's face, the way of a push",
    "normal_force": "force of the tip on the leaf along the normal, positive where it presses [N]",
    "thrust": "thrust of the rotors, an input [N]",
})  # fmt: skip
"""What every task has, by name. Beside it stand the scenario's numbers: `vehicle.mass`, `door.width`, `contact.height`, …"""


class Task:
    """Named CasADi expressions of vehicle and door, SI units, world frame unless the name says another.

    Subclasses say what state and inputs are, and from them how they change. Points are the arm's, the tip last. `vehicle`,
    `door`, `contact`, `limits`, … are numbers, named as in `task_numbers`, in SI units.
    """

    def __init__(self, pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers) -> None:
        self.time = ca.SX.sym("time")
        """Time of the node since the plan's first one, plus the planner's time [s]."""
        self.attitude = ca.vertcat(*map(ca.SX.sym, ("roll", "pitch", "yaw")))
        """Φ, (3, 1) [rad]."""
        self.door_angle = ca.SX.sym("door_angle")
        """α: π/2 is closed [rad]."""
        self.door_rate = ca.SX.sym("door_rate")
        """α̇ [rad/s]."""
        self.arm_angles = ca.SX.sym("arm_angle", pattern.n_joints)
        """H, (n, 1) [rad]."""
        self.thrust = ca.SX.sym("thrust")
        """f_t [N]."""
        self.arm_rates = ca.SX.sym("arm_rate", pattern.n_joints)
        """Ḣ_d, (n, 1) [rad/s]."""
        named = {name: ca.SX.sym(name.replace(".", "_"), size) for name, size in numbers.sizes.items()}
        self.parameters = ca.vertcat(ca.SX(0, 1), *named.values())
        """Symbols of the numbers, (np, 1)."""
        for group in sorted({name.partition(".")[0] for name in named if "." in name}):
            setattr(self, group, _group(group, named))
        self.side_force = ca.SX.sym("side_force", 2) if "actuation.side" in named else ca.SX(2, 1)
        """Body force along x and y of a fully actuated vehicle, (2, 1); 0 of another one [N]."""
        names = point_names, arm_points(pattern, named["arm"], self.arm_angles)
        self.arm_side = 1 if pattern.above else -1
        """+1 where the arm belongs above the rotors' plane, −1 where below."""
        self.fixed_points = tuple(name for name, parent in zip(point_names, pattern.parents, strict=True) if parent < 0)
        """Those of the arm's points that the body carries: the tip of a stick."""
        self.points_in_body = dict(zip(*names, strict=True))
        """Positions of the arm's points in the body by name, the tip last, each (3, 1) [m]."""
        self.tip_in_body = list(self.points_in_body.values())[-1]
        """d, (3, 1) [m]."""
        self._bodies: SymbolicBodies | None = None
        if "bodies.masses" in named:
            self._bodies = SymbolicBodies(pattern, named["arm"], self.arm_angles, _group("bodies", named))

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"a task has no '{name}'; it has {', '.join(self.names())}", name=name, obj=self)

    def names(self) -> list[str]:
        """Everything that an expression may use."""
        every = {*vars(self), *(each for kind in type(self).__mro__ for each in vars(kind))}
        ours = {"names", "symbolic_model", "evaluated", "derivative", "next_state", "parameters", "state", "inputs"}
        return sorted(each for each in every - ours if not each.startswith("_"))

    @cached_property
    def center_of_mass(self) -> Any:
        """Centre of mass c of vehicle and arm, (3, 1), body frame [m]; O_B itself where the arm has no mass."""
        return ca.SX(3, 1) if self._bodies is None else self._bodies.center

    @cached_property
    def rotation(self) -> Any:
        """R, body to world, (3, 3)."""
        return rotation_body_to_world(self.attitude)

    @property
    def opening(self) -> Any:
        """How far the door is open [rad or m]."""
        return self.door.opening_per_angle * (self.door_angle - CLOSED)

    @property
    def opening_rate(self) -> Any:
        """Rate of `opening` [rad/s or m/s]."""
        return self.door.opening_per_angle * self.door_rate

    @property
    def joint(self) -> Any:
        """Value of the URDF's joint [rad or m]."""
        return self.door.closed + self.door.joint_per_angle * (self.door_angle - CLOSED)

    @property
    def leaf_direction(self) -> Any:
        """Direction from the hinge along the leaf, (3, 1)."""
        return self.leaf.leaf_direction

    @property
    def contact_normal(self) -> Any:
        """n_D, the way of a push, (3, 1)."""
        return self.leaf.normal

    @property
    def contact_point(self) -> Any:
        """Point of the leaf that the tip is to touch, (3, 1) [m]."""
        return self.door.hinge_position + self.leaf.contact_from_hinge

    @property
    def lever(self) -> Any:
        """J, how the door's angle moves the contact point, (3, 1) [m]."""
        return self.leaf.lever

    @cached_property
    def across_doorway(self) -> Any:
        r"""Distance of O_B from the hinge along the closed leaf, :math:`a^T(P-P_h)` [m]."""
        return ca.dot(self.door.along, self.position_from_hinge)

    @cached_property
    def into_doorway(self) -> Any:
        r"""Distance of O_B behind the hinge through the doorway, :math:`i^T(P-P_h)`, negative before it [m]."""
        return ca.dot(self.door.into, self.position_from_hinge)

    @property
    def before_panel(self) -> Any:
        """Distance of O_B from the panel that a slide's handle stands on [m]."""
        return ca.dot(self.door.panel, self.position_from_hinge) - self.door.panel_distance

    @cached_property
    def points(self) -> Mapping[str, Any]:
        """Positions of the arm's points by name, each (3, 1) [m]."""
        return {name: self.position + self.rotation @ point for name, point in self.points_in_body.items()}

    @property
    def weight(self) -> Any:
        """m_A g [N]."""
        return weight_of(self.vehicle.mass)

    @cached_property
    def rotors_in_heading(self) -> Any:
        """Force of the rotors in the frame of `tilt_rotation`, (3, 1) [N]."""
        return self.thrust * self.tilt_rotation[:, 2] + self.tilt_rotation[:, :2] @ self.side_force

    @property
    def hinge_torque_at_rest(self) -> Any:
        r"""What acts on a leaf that stands, but friction: :math:`k(\alpha-\alpha_0) + \tau_d + G(\alpha)` [N m]."""
        spring = self.door.stiffness * (self.door_angle - self.door.rest_angle)
        return spring + self.door.disturbance + self.leaf.weight_torque


def _group(group: str, named: Mapping[str, Any]) -> SimpleNamespace:
    """Symbols whose names begin with a group's."""
    return SimpleNamespace(
        **{name.partition(".")[2]: each for name, each in named.items() if name.startswith(f"{group}.")}
    )
