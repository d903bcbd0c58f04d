"""A leaf in the world: where it points, where a place on it is, how far a contact moves, and α in the units of its joint."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from doorman.arrays import Array, frozen
from doorman.kinematics.doors.leaf import leaf_motion as motion


class LeafInWorld:
    """What turns the motion of a leaf in its doorway into places and directions in the world, and values of the URDF's joint."""

    slides: bool
    """Whether the joint is a slide."""
    closed: float
    """Value of the URDF's joint where the door is closed [rad or m]."""
    per_angle: float
    """Change of the joint's value for one of α: 1, or metres."""
    unit: str
    """Unit of the joint's value: `rad` or `m`."""
    _turns: float
    """Sense of α as the door opens, 1 or −1."""
    _sense: float
    """Sense of the joint's value as the door opens, 1 or −1."""
    hinge_position: Array
    """P_h, on the hinge's axis at the height of the leaf's lower edge, or a slide's lower corner, shape (3,), world [m]."""
    contact_offset: float
    """o, how far the contact point lies before the hinge axis, towards the vehicle [m]."""
    in_plane: bool
    """Whether it turns in the plane of the face that it is mounted on."""
    vertical: bool
    """Whether it is a hinge on a plumb axis, on which no weight acts."""
    hand: float
    """1 where the hinge is on the right of somebody who looks along `into`, else −1."""
    azimuth: float
    """Azimuth of `into`, about z from the world's x axis [rad]."""
    lower_limit: float
    """Least α [rad]."""
    upper_limit: float
    """Largest α [rad]."""
    turn: float
    """t of `leaf_motion`: 1 of a hinge, 0 of a slide."""
    slide: float
    """s of `leaf_motion`: 0 of a hinge [m]."""
    _center: Array
    """Centre of mass of the leaf where it is closed, from P_h in the doorway, shape (3,) [m]."""

    def _take_axes(self, into: Array, along: Array, up: Array) -> None:
        """Stand with these axes of the doorway, unit vectors in the world."""
        self.into, self.along, self.up = (frozen(axis + 0.0) for axis in (into, along, up))
        self._level: tuple[list[float], list[float]] = self.into.tolist(), self.along.tolist()
        self.axes = frozen(np.vstack([self.into, self.along, self.up]))
        """Rows `into`, `along` and `up`, (3, 3): from the world to the doorway; its determinant is the door's `hand`."""

    def leaf_direction(self, door_angle: float) -> Array:
        """Unit vector c along the leaf from hinge to latch."""
        angle = motion.turned(self.turn, door_angle)
        return self._in_world(motion.leaf_in_doorway(math.cos(angle), math.sin(angle)))

    def normal(self, door_angle: float) -> Array:
        """Unit normal n_D of the leaf that points away from the vehicle; a growing α moves the leaf against it."""
        angle = motion.turned(self.turn, door_angle)
        return self._in_world(motion.normal_in_doorway(math.cos(angle), math.sin(angle)))

    def normals(self, door_angles: Array) -> Array:
        """Unit normal n_D at many angles, see `normal`."""
        angles = motion.turned(self.turn, door_angles)
        return np.stack(motion.normal_in_doorway(np.cos(angles), np.sin(angles)), axis=-1) @ self.axes[:2]

    def leaf_directions(self, door_angles: Array) -> Array:
        """Unit vector c along the leaf at many angles."""
        angles = motion.turned(self.turn, door_angles)
        return np.stack(motion.leaf_in_doorway(np.cos(angles), np.sin(angles)), axis=-1) @ self.axes[:2]

    def _in_world(self, components: tuple[float, float]) -> Array:
        """A level vector from its components along `into` and `along`; without NumPy's sums, because every step calls it."""
        into, along = components
        (ix, iy, iz), (ax, ay, az) = self._level
        return np.array((into * ix + along * ax, into * iy + along * ay, into * iz + along * az))

    def face(self, door_angle: float) -> tuple[Array, Array]:
        """Two unit vectors in the face, the more level one first: along leaf and hinge, or along hinge and leaf."""
        return self.level_first(self.leaf_direction(door_angle))

    def level_first(self, along: Array) -> tuple[Array, Array]:
        """The same where the leaf has this direction."""
        return (along, self.up) if abs(self.up[2]) >= abs(along[2]) else (self.up, along)

    def away(self, door_angle: float) -> Array:
        """Unit vector from the leaf to a vehicle that comes and goes: against its normal, or away from a lever's face."""
        return self.up if self.in_plane else -self.normal(door_angle)

    def heading(self, door_angle: float) -> float:
        """Yaw of a vehicle that looks along the leaf's normal, or at the face that a lever is mounted on [rad]."""
        if self.in_plane:
            return self.azimuth
        if self.vertical:
            return self.azimuth + self.hand * (door_angle - 0.5 * math.pi)
        normal = self.normal(door_angle)
        return self.azimuth + math.remainder(math.atan2(normal[1], normal[0]) - self.azimuth, 2.0 * math.pi)

    def angle_of(self, offset: Array) -> float:
        """Angle α at which a point of the leaf's surface has an offset from P_h [rad]."""
        middle, (into, along) = 0.5 * (self.lower_limit + self.upper_limit), (self.axes[:2] @ offset).tolist()
        return motion.angle_of(self.turn, self.slide, into, along, self.contact_offset, middle)

    def in_doorway(self, vector: Array) -> Array:
        """A vector's components along `into`, along the closed leaf, and along `up`."""
        return np.asarray(vector @ self.axes.T)

    def from_doorway(self, components: Array) -> Array:
        """A vector from its components in the doorway; the inverse of `in_doorway`."""
        return np.asarray(components @ self.axes)

    def contact_point(self, door_angle: float, distance_from_hinge: float, height: float) -> Array:
        r"""Point of the leaf's surface, :math:`P_h + D_V c(\alpha) - o\,n_D(\alpha) + D_H u`, and the way of a slide."""
        leaf, normal, before = self.leaf_direction(door_angle), self.normal(door_angle), self._before(door_angle)
        return np.asarray(
            self.hinge_position + motion.contact_from_hinge(distance_from_hinge, before, height, leaf, normal, self.up)
        )

    def center_of_mass(self, door_angle: float) -> Array:
        """Centre of mass of the leaf."""
        into, along, up = self._center
        leaf, normal, before = self.leaf_direction(door_angle), self.normal(door_angle), self.way(door_angle) - into
        return np.asarray(self.hinge_position + motion.contact_from_hinge(along, before, up, leaf, normal, self.up))

    def way(self, door_angle: Any) -> Any:
        """How far a slide's face has moved towards the vehicle, from closed, at one angle or many; 0 for a hinge [m]."""
        return motion.way(self.slide, door_angle)

    def _before(self, door_angle: float) -> float:
        """How far the contact point lies before the hinge's axis [m]."""
        return float(self.contact_offset + self.way(door_angle))

    def lever(self, door_angle: float, distance_from_hinge: float) -> Array:
        r"""How α moves the contact point, :math:`J = -D_V n_D - o\,c`, or :math:`-r\,i` of a slide."""
        leaf, normal = self.leaf_direction(door_angle), self.normal(door_angle)
        return np.asarray(motion.lever(self.turn, self.slide, distance_from_hinge, self.contact_offset, leaf, normal))

    def lever_length(self, distance_from_hinge: float) -> float:
        """Speed of the contact point along the normal for a unit rate of α: D_V, or `per_angle` [m]."""
        return float(motion.lever_length(self.turn, self.slide, distance_from_hinge))

    def angle_of_face(self, before: float, distance_from_hinge: float) -> float:
        """By how much α of a tip on the face is less if the face stands before its place [rad]."""
        return motion.angle_of_face(self.turn, self.slide, before, distance_from_hinge)

    def onto_face(self, point: Array, door_angle: float) -> Array:
        r"""A point moved along the leaf's normal to where it is touched, :math:`q + (n_D^T(P_h - q) - o)\,n_D`."""
        normal = self.normal(door_angle)
        return np.asarray(point + (normal @ (self.hinge_position - point) - self._before(door_angle)) * normal)

    def joint_value(self, door_angle: float) -> float:
        """Value of the URDF's joint at α [rad or m]."""
        return self.closed + self._sense * self.opening_of(float(door_angle))

    def joint_rate(self, door_rate: float) -> float:
        """Rate of the URDF's joint [rad/s or m/s]."""
        return self._sense * self._turns * self.per_angle * door_rate

    def joint_torque(self, torque: float) -> float:
        """Torque, or force, in the URDF's joint [N m or N]."""
        return self._sense * self._turns * torque / self.per_angle

    def angle_of_joint(self, value: float) -> float:
        """α at a value of the URDF's joint [rad]."""
        return self.angle_of_opening(self._sense * (float(value) - self.closed))

    def opening_of(self, door_angle: float) -> float:
        """How far the door is open from closed [rad or m]."""
        return self._turns * self.per_angle * (door_angle - 0.5 * math.pi)

    def torque_of_closer(self, preload: float) -> float:
        """Torque of a closer that shuts the door, in the sense of damping [N m]."""
        return self._turns * preload

    def angle_of_opening(self, opening: float) -> float:
        """α of a door that is so far open [rad]."""
        return 0.5 * math.pi + self._turns * opening / self.per_angle

    def in_words(self, door_angle: float, digits: int = 1) -> str:
        """Angle as people say it: in degrees, or a slide's opening in metres."""
        return (
            f"{round(self.opening_of(door_angle), 3) + 0.0:.3f} m"
            if self.slides
            else f"{math.degrees(door_angle):.{digits}f}°"
        )

    def torque_in_words(self, torque: float) -> str:
        """A torque in the hinge in N m, or a slide's force in N."""
        return f"{torque / self.per_angle:.2f} {'N' if self.slides else 'N m'}"

    def rate_in_words(self, rate: float) -> str:
        """A rate of α in rad/s, or a slide's speed in m/s."""
        return f"{self.per_angle * rate:.3f} {self.unit}/s"

    def way_in_words(self, way: float) -> str:
        """A difference of α as people say it: in degrees, or a slide's in centimetres."""
        return f"{1e2 * self.per_angle * way:.1f} cm" if self.slides else f"{math.degrees(way):.1f}°"
