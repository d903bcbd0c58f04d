r"""A door task whose tip is tied to the contact point: where the vehicle is follows from attitude, arm and door.

:math:`P + R\,d = P_h + D_V c(\alpha) - o\,n_D + D_H u`, hence :math:`\dot P = \dot\alpha J - R(\Omega\times d + J_d\dot H)` with
the lever :math:`J = -D_V n_D - o\,c`. On a vertical hinge u is up, the leaf's direction
:math:`c = [\cos\beta,\ \sin\beta,\ 0]^T` with its azimuth :math:`\beta = \psi_D + \sigma\alpha`, and
:math:`n_D = \sigma[\sin\beta,\ -\cos\beta,\ 0]^T`: σ = ±1 is the door's hand and ψ_D the azimuth of a right angle's opening.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Any

import casadi as ca

from doorman.kinematics.doors.leaf.leaf_symbols import VerticalLeaf, leaf_in_symbols
from doorman.kinematics.symbols import rotation_body_to_world
from doorman.kinematics.task import Task
from doorman.ocp.symbolic_model import SymbolicModel


class TiedTask(Task, ABC):
    """Vectors with `in_heading` in their names are in the frame that looks along the vehicle's heading, z up. See `Task`."""

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

    @cached_property
    def tilt_rotation(self) -> Any:
        """Body to heading frame, (3, 3)."""
        return rotation_body_to_world(ca.vertcat(self.attitude[:2], 0))

    @cached_property
    def leaf(self) -> VerticalLeaf:
        """Geometry of the leaf; its vectors `in_heading` are seen along the vehicle's heading."""
        return leaf_in_symbols(self.door, self.contact, self.door_angle, self.attitude[2])

    @cached_property
    def tip_position(self) -> Any:
        """P_e, the contact point, (3, 1) [m]."""
        return self.contact_point

    @cached_property
    def position_from_hinge(self) -> Any:
        """P − P_h of O_B, (3, 1) [m]."""
        return self.leaf.contact_from_hinge - self.rotation @ self.tip_in_body

    @cached_property
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
    def before_leaf(self) -> Any:
        """Distance of O_B from the plane of the leaf's face [m]."""
        return ca.dot(self.tilt_rotation.T @ self.leaf.normal_in_heading, self.tip_in_body)

    @cached_property
    def half_width(self) -> Any:
        """R_A, as the paper takes the disc for level between the jambs [m]."""
        return self.vehicle.radius

    @cached_property
    def normal_force(self) -> Any:
        r"""The rotors' share along the normal, :math:`n_D^T R\,[f_x, f_y, f_t]^T`, which these models take for the tip's [N]."""
        return ca.dot(self.leaf.normal_in_heading, self.rotors_in_heading)

    @property
    def lifted(self) -> Any:
        """Torque that a tip makes which hangs on a lever with all of the vehicle's weight; 0 on a vertical hinge [N m]."""
        return self.leaf.lift(self.weight)

    @property
    def hinge_torque(self) -> Any:
        r"""τ in the sense of damping [N m].

        .. math:: \tau = b\dot\alpha + \tau_c\tanh(\dot\alpha/\epsilon) + k(\alpha-\alpha_0) + \tau_d + G(\alpha)
        """
        door, rate = self.door, self.door_rate
        return door.damping * rate + door.friction * ca.tanh(rate / door.friction_rate) + self.hinge_torque_at_rest
