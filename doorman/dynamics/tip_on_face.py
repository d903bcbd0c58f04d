"""The tip on the face in symbols: where it is, how fast it slips, and the force of the compliant contact; see `WholeBodyTask`."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca

from doorman.kinematics.doors.leaf.leaf_symbols import VerticalLeaf, leaf_in_symbols
from doorman.kinematics.task import Task


class TipOnFace(Task):
    """Named expressions of the contact between the tip of a vehicle that flies freely and the leaf. See `Task`."""

    @cached_property
    def rate_to_goal(self) -> Any:
        """Rate of α towards the goal [rad/s]."""
        return self.reference.sense * self.door_rate

    @cached_property
    def leaf(self) -> VerticalLeaf:
        """Geometry of the leaf, in the world's axes."""
        return leaf_in_symbols(self.door, self.contact, self.door_angle, 0)

    @cached_property
    def tilt_rotation(self) -> Any:
        """Body to world, (3, 3)."""
        return self.rotation

    @cached_property
    def tip_position(self) -> Any:
        """Place p_t of the tip, (3, 1) [m]."""
        return self.position + self.rotation @ self.tip_in_body

    @cached_property
    def tip_velocity(self) -> Any:
        """Velocity of the tip, (3, 1) [m/s]."""
        moved = ca.jtimes(self.tip_in_body, self.arm_angles, self.arm_rates)
        return self.velocity + self.rotation @ (ca.cross(self.body_rates, self.tip_in_body) + moved)

    @cached_property
    def off_place(self) -> Any:
        """The tip relative to the contact point, (3, 1) [m]."""
        return self.tip_position - self.contact_point

    @cached_property
    def place(self) -> Any:
        """Place of the tip on the face relative to the contact point, along and up, (2, 1) [m]."""
        return ca.vertcat(ca.dot(self.leaf_direction, self.off_place), ca.dot(self.leaf.up, self.off_place))

    @cached_property
    def depth(self) -> Any:
        """Depth δ, positive where the tip is in the face [m]."""
        return ca.dot(self.contact_normal, self.off_place)

    @cached_property
    def lever_of_tip(self) -> Any:
        """J at the tip, (3, 1) [m]."""
        return self.leaf.lever_at(self.tip_position - self.door.hinge_position)

    @cached_property
    def slip_velocity(self) -> Any:
        """Velocity v of the tip relative to the face, (3, 1) [m/s]."""
        return self.tip_velocity - self.lever_of_tip * self.door_rate

    @cached_property
    def closing_speed(self) -> Any:
        """Closing speed δ̇ of tip and face [m/s]."""
        return ca.dot(self.contact_normal, self.slip_velocity)

    @cached_property
    def pressed(self) -> Any:
        """σ [m]."""
        return 0.5 * (self.depth + ca.sqrt(self.depth**2 + 4 * self.contact.smoothing**2))

    @cached_property
    def touches(self) -> Any:
        """0 in free air, 1 in firm contact or where the tip is tied."""
        g = self.contact.tied
        return g + (1 - g) * self.pressed / (self.pressed + self.contact.smoothing)

    @cached_property
    def spring_force(self) -> Any:
        """λ at rest, a pull negative [N]."""
        g = self.contact.tied
        return self.contact.stiffness * ((1 - g) * self.pressed + g * self.depth)

    @cached_property
    def normal_force(self) -> Any:
        """λ [N]."""
        return self.spring_force + self.contact.damping * self.touches * self.closing_speed

    @cached_property
    def slipped(self) -> Any:
        """e: the tip's place on the face less the one where it sticks or is held, (2, 1) [m]."""
        return self.place - self.contact.stick

    @cached_property
    def force_in_face(self) -> Any:
        """F in the plane of the face, along and up: friction, or what the gripper holds, (2, 1) [N]."""
        contact, face = self.contact, ca.horzcat(self.leaf_direction, self.leaf.up)
        slipped, rubs = self.slipped, contact.friction * self.normal_force
        held = (1 - contact.tied) * rubs / ca.sqrt(ca.dot(slipped, slipped) + contact.give**2) * slipped
        held += contact.tied * contact.stiffness * slipped
        return held + contact.slip_damping * self.touches * (face.T @ self.slip_velocity)

    @cached_property
    def force(self) -> Any:
        """F of the tip on the leaf, (3, 1) [N]."""
        face = ca.horzcat(self.leaf_direction, self.leaf.up)
        return self.normal_force * self.contact_normal + face @ self.force_in_face
