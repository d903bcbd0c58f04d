"""The doorway: where between the jambs a vehicle may be, and how near to the leaf it is."""

from __future__ import annotations

import math

from doorman.arrays import Array
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model

NO_GAP = 0.018
"""Between disc and leaf: one that is nearer is too near, however the vehicle moves [m]."""

_SENT_BACK = 1.5
"""Share of the way that a vehicle is nearer to a jamb than it may be, by which its place is moved away."""
_FARTHEST, _FADING = 0.025, 0.03
"""A force to the side has faded so far beyond the margin, over so much of the way [m]."""
DRIFTS = 0.3
"""A vehicle drifts on for so long before it brakes: its attitude's lag, and a tenth of a second for which that is doubted [s]."""


class Doorway:
    """Places of the vehicle between the jambs, a margin [m] from them, the planner's if not given."""

    def __init__(self, model: Model, margin: float | None = None) -> None:
        room = model.vehicle.radius + (model.scenario.planner.margin if margin is None else margin)
        self._door, self._coupling, self._radius = model.door, model.coupling, model.vehicle.radius
        self._bounds, self._before_wall = model.surroundings == "doorway", model.door.side == "pull"
        self._has_jambs = model.door.upright and model.door.framed
        self.lowest, self.highest = room, model.door.width - room
        """Bounds of the distance from the hinge along the closed leaf that keep the margin [m]."""
        self.middle = 0.5 * (self.lowest + self.highest)
        """The distance as far from both jambs [m]."""

    def inside(self, place: Array, planned: Array, position: Array, velocity: Array) -> Array:
        """A place no nearer to a jamb than the plan is, or may be.

        A vehicle that is nearer, or will be soon, is sent back beyond.
        """
        if not self._bounded(position):
            return place
        planned_at, at = self.along(planned), self.along(place)
        lowest, highest = min(self.lowest, planned_at), max(self.highest, planned_at)
        soon = self._soon(position, velocity)
        allowed = min(max(at, lowest), highest) + _SENT_BACK * (min(max(soon, lowest), highest) - soon)
        return place + (allowed - at) * self._door.along

    def along(self, position: Array) -> float:
        """Distance of a place from the hinge along the closed leaf [m]."""
        return float((position - self._door.hinge_position) @ self._door.along)

    def beyond(self, position: Array) -> float:
        """How much nearer to a jamb than the margin a place is, along the closed leaf: positive at the latch jamb [m]."""
        if not self._bounded(position):
            return 0.0
        y = self.along(position)
        return max(y - max(self.highest, self.middle), 0.0) - max(min(self.lowest, self.middle) - y, 0.0)

    def room(self, force: float, position: Array, velocity: Array) -> float:
        """How much of a force there is room for: all of it inside, none of it where it would take the vehicle to a jamb."""
        if not self._bounded(position):
            return 1.0
        soon = self._soon(position, velocity)
        beyond = soon - self.highest if force > 0.0 else self.lowest - soon
        return min(max((_FARTHEST - beyond) / _FADING, 0.0), 1.0)

    def room_beside(self, position: Array, speed: float) -> float:
        """Between rotor disc and the jamb that a vehicle moves to, along the closed leaf [m]."""
        at = self.along(position)
        return (self._door.width - at if speed > 0.0 else at) - self._radius

    def gap_to_jambs(self, position: Array, velocity: Array) -> float:
        """Between rotor disc and the nearer jamb, for a vehicle that drifts on a little [m]."""
        return min(self._gap_to_jambs(position), self._gap_to_jambs(position + DRIFTS * velocity))

    def _bounded(self, position: Array) -> bool:
        """Whether the jambs bound where a vehicle may be: always in a doorway, else only where its disc is between them."""
        if self._bounds or self._before_wall or not self._has_jambs:
            return self._bounds
        into = float(self._door.in_doorway(position - self._door.hinge_position)[0])
        return -self._door.frame_depth - self._radius < into < self._door.frame_back + self._radius

    def _gap_to_jambs(self, position: Array) -> float:
        if not self._has_jambs:
            return math.inf
        into, along, _ = self._door.in_doorway(position - self._door.hinge_position)
        before = max(float(-self._door.frame_depth - into), float(into - self._door.frame_back), 0.0)
        beside = max(min(float(along), float(self._door.width - along)), 0.0)
        return math.hypot(before, beside) - self._radius

    def gap(self, position: Array, attitude: Array, door_angle: float) -> float:
        """Between rotor disc and leaf, wherever the tip is [m]."""
        upwards, normal = rotation_body_to_world(attitude)[:, 2], self._door.normal(door_angle)
        return self.gap_to(position, upwards, self._coupling.contact_point(door_angle), normal)

    def gap_to(self, position: Array, upwards: Array, contact_point: Array, normal: Array) -> float:
        """The same of a disc with this upward normal, and a leaf with this contact point and normal [m]."""
        if self._door.in_plane and self._door.panel is not None:  # what is near is the face that a lever is mounted on
            away, plane = self._door.panel
            normal, distance = -self._door.from_doorway(away), -plane
        else:
            distance = float(normal @ (contact_point - self._door.hinge_position))
        slope = float(upwards @ normal)
        return (
            distance
            - float(normal @ (position - self._door.hinge_position))
            - self._radius * math.sqrt(max(1.0 - slope * slope, 0.0))
        )

    def _soon(self, position: Array, velocity: Array) -> float:
        """Where along the closed leaf a vehicle will be that drifts on [m]."""
        return self.along(position + DRIFTS * velocity)
