r"""A door task in symbols: what dynamics, constraints and costs are written with.

The tip is tied to the contact point, :math:`P + R\,d = P_h + D_V c(\alpha) - o\,n_D + D_H u`, hence
:math:`\dot P = \dot\alpha J - R(\Omega\times d + J_d\dot H)` with the lever :math:`J = -D_V n_D - o\,c`. On a vertical hinge
u is up, the leaf's direction :math:`c = [\cos\beta,\ \sin\beta,\ 0]^T` with its azimuth :math:`\beta = \psi_D + \sigma\alpha`,
and :math:`n_D = \sigma[\sin\beta,\ -\cos\beta,\ 0]^T`: σ = ±1 is the door's hand and ψ_D the azimuth of a right angle's opening.
`leaf_symbols` has all kinds of leaves.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cached_property
from types import SimpleNamespace
from typing import Any, NoReturn

import casadi as ca

from doorman.kinematics.doors.leaf.leaf_symbols import CLOSED, VerticalLeaf, leaf_in_symbols
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.symbols import arm_points, rotation_body_to_world
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.body_symbols import SymbolicBodies
from doorman.kinematics.vehicles.vehicle import GRAVITY
from doorman.ocp.symbolic_model import SymbolicModel


class Task(ABC):
    """Named CasADi expressions of vehicle and door, SI units, world frame unless the name says another.

    Subclasses say what the state and the inputs are, and from them `derivative`, `body_rates` and `normal_force`.

    Args:
        pattern: Of the arm's constants.
        point_names: Of the arm's points, the tip last.
        numbers: Their names and sizes become symbols; see `doorman.kinematics.task_numbers`.
    """

    state: Any
    """Symbols of x, (nx, 1)."""
    inputs: Any
    """Symbols of u, (nu, 1)."""
    body_rates: Any
    """Ω, (3, 1), body frame [rad/s]."""
    vehicle: Any
    """Numbers of the vehicle: `mass`, `radius`, `max_thrust` [kg, m, N]."""
    door: Any
    """Numbers of the door: `width`, `height`, `inertia`, `hinge_position`, `damping`, `friction`, …, SI units."""
    contact: Any
    """Numbers of the contact point: `distance_from_hinge`, `height`, and `offset` before the hinge's axis [m]."""
    limits: Any
    """Numbers of the planner: `margin` [m], `least_cosine` of the tilt."""
    push: Any
    """Numbers of `[push]`, where the tip can only push."""

    def __init__(self, pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers) -> None:
        self.time = ca.SX.sym("time")
        """Of the node, since the plan's first one plus the planner's time [s]."""
        self.attitude = _symbols("roll", "pitch", "yaw")
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
        self._named = named
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

    @property
    @abstractmethod
    def derivative(self) -> Any:
        """ẋ, (nx, 1)."""

    def symbolic_model(self, timed: bool = False) -> SymbolicModel:
        """RK4 of ẋ; no step leads through the poles of the Euler angles."""
        return SymbolicModel(
            self.state, self.inputs, self.derivative, parameters=self.parameters,
            node_parameters=self.time if timed else None, domain=ca.cos(self.attitude[1]),
        )  # fmt: skip

    def __getattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a task has no '{name}'; it has {', '.join(self.names())}", name=name, obj=self)

    def names(self) -> list[str]:
        """Everything that an expression may use."""
        every = {*vars(self), *(each for kind in type(self).__mro__ for each in vars(kind))}
        ours = {"names", "symbolic_model", "evaluated", "derivative", "parameters", "state", "inputs"}
        return sorted(each for each in every - ours if not each.startswith("_"))

    @cached_property
    def center_of_mass(self) -> Any:
        """Centre of mass c of vehicle and arm, (3, 1), body frame [m]; O_B itself where the arm has no mass."""
        return ca.SX(3, 1) if self._bodies is None else self._bodies.center

    @cached_property
    def rotation(self) -> Any:
        """R, body to world, (3, 3)."""
        return rotation_body_to_world(self.attitude)

    @cached_property
    def tilt_rotation(self) -> Any:
        """Body to heading frame (z up, x along the vehicle's heading), (3, 3)."""
        return rotation_body_to_world(ca.vertcat(self.attitude[:2], 0))

    @cached_property
    def _leaf(self) -> VerticalLeaf:
        return leaf_in_symbols(self.door, self.contact, self.door_angle, self.attitude[2])

    @property
    def normal_in_heading(self) -> Any:
        """n_D in the heading frame, (3, 1): of a vertical hinge only β − ψ enters."""
        return self._leaf.normal_in_heading

    @property
    def leaf_in_heading(self) -> Any:
        """`leaf_direction` in the heading frame, (3, 1)."""
        return self._leaf.leaf_in_heading

    @property
    def opening(self) -> Any:
        """How far the door is open [rad]."""
        return CLOSED - self.door_angle

    @property
    def opening_rate(self) -> Any:
        """Rate of `opening` [rad/s]."""
        return -self.door_rate

    @property
    def leaf_direction(self) -> Any:
        """Direction from the hinge along the leaf, (3, 1)."""
        return self._leaf.leaf_direction

    @property
    def contact_normal(self) -> Any:
        """n_D, the way the tip pushes, (3, 1)."""
        return self._leaf.normal

    @property
    def across_doorway(self) -> Any:
        r"""Distance of O_B from the hinge along the closed leaf, :math:`a^T(P-P_h)` [m]."""
        return self._leaf.across(self.rotation @ self.tip_in_body)

    @property
    def into_in_heading(self) -> Any:
        """Direction from the vehicle's side through the closed leaf, in the heading frame, (3, 1)."""
        return self._leaf.into_in_heading

    @property
    def into_doorway(self) -> Any:
        r"""Distance of O_B behind the hinge through the doorway, :math:`i^T(P-P_h)`, negative before it [m]."""
        return self._leaf.into(self.tilt_rotation @ self.tip_in_body)

    @property
    def panel_in_heading(self) -> Any:
        """Normal of the panel that a slide's handle stands on, towards the vehicle, in the heading frame, (3, 1)."""
        return self._leaf.in_heading(self.door.panel)

    @property
    def before_panel(self) -> Any:
        """Distance of O_B from that panel [m]."""
        return ca.dot(self.door.panel, self.position_from_hinge) - self.door.panel_distance

    @property
    def contact_from_hinge(self) -> Any:
        """The contact point relative to P_h, (3, 1) [m]."""
        return self._leaf.contact_from_hinge

    @property
    def lever(self) -> Any:
        """J, how the door's angle moves the contact point, (3, 1) [m]."""
        return self._leaf.lever

    @property
    def lever_in_heading(self) -> Any:
        """J in the heading frame, (3, 1) [m]."""
        return self._leaf.lever_in_heading

    @property
    def contact_point(self) -> Any:
        """Point where the tip touches the leaf, (3, 1) [m]."""
        return self.door.hinge_position + self.contact_from_hinge

    @property
    def tip_position(self) -> Any:
        """P_e, tied to the contact point, (3, 1) [m]."""
        return self.contact_point

    @cached_property
    def position_from_hinge(self) -> Any:
        """P − P_h of O_B, (3, 1) [m]."""
        return self.contact_from_hinge - self.rotation @ self.tip_in_body

    @property
    def position(self) -> Any:
        """P of O_B, (3, 1) [m]."""
        return self.door.hinge_position + self.position_from_hinge

    @cached_property
    def velocity(self) -> Any:
        """Ṗ of O_B, (3, 1) [m/s]."""
        moved = ca.jtimes(self.tip_in_body, self.arm_angles, self.arm_rates)
        in_body = ca.cross(self.body_rates, self.tip_in_body) + moved
        return self.door_rate * self.lever - self.rotation @ in_body

    @cached_property
    def points(self) -> Mapping[str, Any]:
        """Positions of the arm's points by name, each (3, 1) [m]."""
        return {name: self.position + self.rotation @ point for name, point in self.points_in_body.items()}

    @property
    def weight(self) -> Any:
        """m_A g [N]."""
        return self.vehicle.mass * GRAVITY

    @property
    def thrust_along_normal(self) -> Any:
        r"""The rotors' share along the normal, :math:`n_D^T R\,[f_x, f_y, f_t]^T` [N]; f_x and f_y are 0 of upright rotors."""
        return ca.dot(self.normal_in_heading, self.rotors_in_heading)

    @cached_property
    def rotors_in_heading(self) -> Any:
        """Force of the rotors in the heading frame, (3, 1) [N]."""
        return self.thrust * self.tilt_rotation[:, 2] + self.tilt_rotation[:, :2] @ self.side_force

    @property
    def lifted(self) -> Any:
        """Torque that a tip makes which hangs on a lever with all of the vehicle's weight; 0 on a vertical hinge [N m]."""
        return self._leaf.lift(self.weight)

    @property
    def normal_force(self) -> Any:
        """Force of the tip on the door along its normal, positive where it presses [N]."""
        return self.thrust_along_normal

    @property
    def hinge_torque(self) -> Any:
        r"""τ in the sense of damping [N m].

        .. math:: \tau = b\dot\alpha + \tau_c\tanh(\dot\alpha/\epsilon) + k(\alpha-\alpha_0) + \tau_d + G(\alpha)

        G is that of the leaf's weight: 0 on a vertical hinge.
        """
        door, rate = self.door, self.door_rate
        friction = door.friction * ca.tanh(rate / door.friction_rate)
        spring = door.stiffness * (self.door_angle - door.rest_angle)
        return door.damping * rate + friction + spring + door.disturbance + self._leaf.weight_torque


def _symbols(*names: str) -> Any:
    return ca.vertcat(*(ca.SX.sym(name) for name in names))


def _group(group: str, named: Mapping[str, Any]) -> SimpleNamespace:
    """Symbols whose names begin with a group's."""
    return SimpleNamespace(
        **{name.partition(".")[2]: each for name, each in named.items() if name.startswith(f"{group}.")}
    )
