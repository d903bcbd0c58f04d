"""The tip on the face in symbols: where it is, how fast it slips, and the force of the compliant contact; see `WholeBodyTask`."""

from __future__ import annotations

from functools import cached_property
from types import SimpleNamespace
from typing import Any

import casadi as ca

from doorman.kinematics.symbols import body_rates, rotation_body_to_world
from doorman.planning.mechanism import Mechanism


class TipOnFace:
    """Named CasADi expressions of the contact between tip and mechanism, SI units, world frame."""

    position: Any
    """P of O_B, (3, 1) [m]."""
    velocity: Any
    """V of O_B, (3, 1) [m/s]."""
    attitude: Any
    """Φ, (3, 1) [rad]."""
    attitude_rates: Any
    """Φ̇, (3, 1) [rad/s]."""
    joint: Any
    """q of the mechanism [rad or m]."""
    joint_rate: Any
    """q̇ of the mechanism [rad/s or m/s]."""
    arm_angles: Any
    """H, (n, 1) [rad]."""
    arm_rates: Any
    """Ḣ, (n, 1) [rad/s]."""
    tip_in_body: Any
    """d(H), (3, 1), body frame [m]."""
    of: dict[str, SimpleNamespace]
    """Numbers of the problem, by group and name."""
    mechanism: Mechanism
    """What the tip pushes."""

    @cached_property
    def rotation(self) -> Any:
        """R, body to world, (3, 3)."""
        return rotation_body_to_world(self.attitude)

    @cached_property
    def tip(self) -> Any:
        """Place p_t of the tip, (3, 1) [m]."""
        return self.position + self.rotation @ self.tip_in_body

    @cached_property
    def tip_velocity(self) -> Any:
        """Velocity of the tip, (3, 1) [m/s]."""
        moved = ca.jtimes(self.tip_in_body, self.arm_angles, self.arm_rates)
        turned = ca.cross(body_rates(self.attitude, self.attitude_rates), self.tip_in_body)
        return self.velocity + self.rotation @ (turned + moved)

    @cached_property
    def normal(self) -> Any:
        """n(q), outward, (3, 1)."""
        return self.mechanism.carried(self.joint, self.of["mechanism"].normal)

    @cached_property
    def along(self) -> Any:
        """A direction in the face, horizontal in a door, (3, 1)."""
        return self.mechanism.carried(self.joint, self.of["mechanism"].along)

    @cached_property
    def off_place(self) -> Any:
        """The tip relative to the contact point, (3, 1) [m]."""
        return self.tip - self.mechanism.moved(self.joint, self.of["mechanism"].point)

    @cached_property
    def up_the_face(self) -> Any:
        """The other direction in the face, whatever the hand, (3, 1)."""
        return self.of["mechanism"].hand * ca.cross(self.along, self.normal)

    @cached_property
    def place(self) -> Any:
        """Place of the tip on the face relative to the contact point, along and up, (2, 1) [m]."""
        return ca.vertcat(ca.dot(self.along, self.off_place), ca.dot(self.up_the_face, self.off_place))

    @cached_property
    def depth(self) -> Any:
        """Depth δ, positive where the tip is in the face [m]."""
        return -ca.dot(self.normal, self.off_place)

    @cached_property
    def slip_velocity(self) -> Any:
        """Velocity v of the tip relative to the face, (3, 1) [m/s]."""
        return self.tip_velocity - self.mechanism.lever(self.tip) * self.joint_rate

    @cached_property
    def closing_speed(self) -> Any:
        """Closing speed δ̇ of tip and face [m/s]."""
        return -ca.dot(self.normal, self.slip_velocity)

    @cached_property
    def pressed(self) -> Any:
        """σ [m]."""
        return 0.5 * (self.depth + ca.sqrt(self.depth**2 + 4 * self.of["contact"].smoothing ** 2))

    @cached_property
    def touches(self) -> Any:
        """0 in free air, 1 in firm contact."""
        return self.pressed / (self.pressed + self.of["contact"].smoothing)

    @cached_property
    def spring_force(self) -> Any:
        """λ at rest [N]."""
        return self.of["contact"].stiffness * self.pressed

    @cached_property
    def normal_force(self) -> Any:
        """λ [N]."""
        return self.spring_force + self.of["contact"].damping * self.touches * self.closing_speed

    @cached_property
    def slipped(self) -> Any:
        """e: the tip's place on the face less the one where it sticks, (2, 1) [m]."""
        return self.place - self.of["contact"].stick

    @cached_property
    def force(self) -> Any:
        """F of the tip on the mechanism, (3, 1) [N]."""
        contact = self.of["contact"]
        slipped, grip = self.slipped, contact.friction * self.normal_force
        held = grip / ca.sqrt(ca.dot(slipped, slipped) + contact.give**2) * slipped
        held += (
            contact.slip_damping
            * self.touches
            * ca.vertcat(ca.dot(self.along, self.slip_velocity), ca.dot(self.up_the_face, self.slip_velocity))
        )
        return -self.normal_force * self.normal + held[0] * self.along + held[1] * self.up_the_face
