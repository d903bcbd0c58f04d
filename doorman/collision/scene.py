"""Exact distances between vehicle and door: an FCL scene of the URDFs' collision shapes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import fcl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.arrays import Array, frozen
from doorman.checks import numbers, vector
from doorman.collision.shapes import Shape, arm_joint_of_links, read_shapes, tip_shapes
from doorman.collision.surroundings import ROUNDED
from doorman.exceptions import DimensionError, UrdfError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.one_line import OneLine

Indices = NDArray[np.int64]


class PairBounds(NamedTuple):
    """Pairs of shapes whose distance is bounded from below."""

    first: Indices
    """First shape of each pair, shape (n_pairs,)."""
    second: Indices
    """Second shape of each pair, shape (n_pairs,)."""
    extents: Array
    """Half extents of each shape's box, in the shape's frame, shape (n_shapes, 3) [m]."""
    radii: Array
    """Radius of each shape's bounding sphere, shape (n_shapes,) [m]."""

    def at(self, placements: Array) -> Array:
        """Bounds at m configurations."""
        centers, rotations = placements[:, :, :3, 3], placements[:, :, :3, :3]
        apart = centers[:, self.first] - centers[:, self.second]
        turned = np.abs(np.swapaxes(rotations[:, self.first], 2, 3) @ rotations[:, self.second])
        bounds = np.full(apart.shape[:2], -np.inf)
        for box, other, axes in (
            (self.first, self.second, turned),
            (self.second, self.first, np.swapaxes(turned, 2, 3)),
        ):
            local = np.abs(np.einsum("mkij,mki->mkj", rotations[:, box], apart)) - self.extents[box]
            from_ball = np.linalg.norm(np.maximum(local, 0.0), axis=2) - self.radii[other]
            gaps = local - np.einsum("mkij,kj->mki", axes, self.extents[other])
            bounds = np.maximum(bounds, np.maximum(from_ball, gaps.max(axis=2)))
        return bounds


_BLOCK = 256
"""Configurations whose bounds are in memory at once."""


@dataclass(frozen=True)
class Clearance:
    """Distance of the closest pair of shapes."""

    distance: float
    """[m]; negative: depth of penetration."""
    first: str
    """Shape of the vehicle."""
    second: str
    """Shape of the door, or of the vehicle itself."""


@dataclass(frozen=True, eq=False, repr=False)
class Clearances(OneLine):
    """Distance of the closest pair of shapes at each of m configurations."""

    distances: Array
    """Shape (m,) [m]; negative: depth of penetration."""
    pairs: tuple[tuple[str, str], ...]
    """Names of the closest pair at each configuration."""

    @property
    def worst(self) -> Clearance:
        """The smallest of them."""
        index = int(np.argmin(self.distances))
        return Clearance(float(self.distances[index]), *self.pairs[index])


class CollisionScene:
    """Vehicle and door as FCL shapes, paired but for the tip with the leaf and for what hangs on each other."""

    def __init__(self, vehicle: Vehicle, door: Door, ignored: Iterable[tuple[str, str]] = ()) -> None:
        self.vehicle = vehicle
        self.door = door
        self._ignored = frozenset(ignored)
        vehicle_shapes, door_shapes = read_shapes(vehicle.urdf), read_shapes(door.urdf)
        for shapes, owner in ((vehicle_shapes, vehicle), (door_shapes, door)):
            if not shapes:
                raise UrdfError(
                    "no collision shapes", file=owner.urdf, field="/robot/link/collision", given="none",
                    allowed="at least one link with <collision>",
                )  # fmt: skip
        self.shapes: tuple[Shape, ...] = (*vehicle_shapes, *door_shapes)
        self._n_vehicle = len(vehicle_shapes)
        self._objects = [fcl.CollisionObject(shape.geometry) for shape in self.shapes]
        first, second = np.array(self._relevant_pairs(set(self._ignored))).T
        self._bounds = PairBounds(
            first, second,
            np.array([shape.half_extents for shape in self.shapes]), np.array([shape.radius for shape in self.shapes]),
        )  # fmt: skip
        self._joints, self._on_joints = self._carried()
        self._request = fcl.DistanceRequest(enable_nearest_points=False, enable_signed_distance=True)

    def __reduce__(self) -> tuple[Any, ...]:
        return CollisionScene, (self.vehicle, self.door, self._ignored)  # FCL's shapes cannot be copied

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Names of all pairs that are checked."""
        indices = zip(self._bounds.first, self._bounds.second, strict=True)
        return tuple((self.shapes[i].name, self.shapes[j].name) for i, j in indices)

    def min_clearance(
        self, position: ArrayLike, rotation_body_to_world: ArrayLike, arm_angles: ArrayLike, door_angle: float
    ) -> Clearance:
        """Distance of the closest pair."""
        return self.min_clearance_along(*self._single(position, rotation_body_to_world, arm_angles, door_angle)).worst

    def collides(
        self, position: ArrayLike, rotation_body_to_world: ArrayLike, arm_angles: ArrayLike, door_angle: float
    ) -> list[Clearance]:
        """All pairs that overlap, the deepest first."""
        placements = self._placements(*self._single(position, rotation_body_to_world, arm_angles, door_angle))
        near = np.flatnonzero(self._bounds.at(placements)[0] <= 0.0)
        names = self.pairs
        found = [Clearance(self._distance(placements[0], int(k)), *names[k]) for k in near]
        return sorted((pair for pair in found if pair.distance < 0.0), key=lambda pair: pair.distance)

    def min_clearance_along(
        self,
        positions: ArrayLike,
        rotations: ArrayLike,
        arm_angles: ArrayLike,
        door_angles: ArrayLike,
        stop_below: float = -np.inf,
    ) -> Clearances:
        """Distance of the closest pair at each of m configurations; about 0.1 ms each."""
        placements = self._placements(*self._checked(positions, rotations, arm_angles, door_angles))
        bounds = self._bounds.at(placements)
        found = [self._closest(*each, stop_below=stop_below) for each in zip(placements, bounds, strict=True)]
        names = self.pairs
        return Clearances(frozen([distance for distance, _ in found]), tuple(names[pair] for _, pair in found))

    def least_clearance(
        self, positions: ArrayLike, rotations: ArrayLike, arm_angles: ArrayLike, door_angles: ArrayLike
    ) -> Clearance:
        """Distance of the closest pair at the closest of m configurations."""
        given = self._checked(positions, rotations, arm_angles, door_angles)
        best, pair = np.inf, 0
        for first in range(0, len(given[0]), _BLOCK):
            placements = self._placements(*(array[first : first + _BLOCK] for array in given))
            bounds = self._bounds.at(placements)
            for m in np.argsort(bounds.min(axis=1)):
                best, pair = self._closest(placements[m], bounds[m], best, pair)
        return Clearance(best, *self.pairs[pair])

    def _closest(
        self, placements: Array, bounds: Array, best: float = np.inf, pair: int = 0, stop_below: float = -np.inf
    ) -> tuple[float, int]:
        """Distance and index of the closest pair at one configuration; those given, if none is closer."""
        for k in np.argsort(bounds).tolist():
            if bounds[k] >= best or best < stop_below:
                break  # the others cannot be closer: their bounds are larger still
            distance = self._distance(placements, k)
            if distance < best:
                best, pair = distance, k
        return best, pair

    def _relevant_pairs(self, ignored: set[tuple[str, str]]) -> list[tuple[int, int]]:
        joint, tip, touched = arm_joint_of_links(self.vehicle), tip_shapes(self.vehicle), self.door.touched
        own, others = range(self._n_vehicle), range(self._n_vehicle, len(self.shapes))
        links = [shape.link for shape in self.shapes]
        pairs = [(i, j) for i in own for j in others if (links[i], links[j]) not in ignored]
        pairs = [(i, j) for i, j in pairs if i not in tip or links[j] not in touched]
        pairs += [(i, j) for i in own for j in own if joint[links[i]] >= 2 and joint[links[j]] == 0]
        return pairs

    def _distance(self, placements: Array, pair: int) -> float:
        """Signed distance of one pair; `placements` of all shapes, shape (n_shapes, 4, 4)."""
        first, second = self._bounds.first[pair], self._bounds.second[pair]
        for index in (first, second):
            matrix = placements[index]
            self._objects[index].setTransform(fcl.Transform(matrix[:3, :3], matrix[:3, 3]))
        return float(fcl.distance(self._objects[first], self._objects[second], self._request, fcl.DistanceResult()))

    def _placements(self, positions: Array, rotations: Array, arm_angles: Array, door_angles: Array) -> Array:
        """Placements of all shapes in the world, shape (m, n_shapes, 4, 4)."""
        body = np.zeros((len(positions), 1, 4, 4))
        body[:, 0, :3, :3], body[:, 0, :3, 3], body[:, 0, 3, 3] = rotations, positions, 1.0
        in_world = body @ self.vehicle.joint_placements_along(arm_angles)
        joints = np.concatenate([in_world, self.door.joint_placements_along(door_angles)], axis=1)
        return np.ascontiguousarray(joints[:, self._joints] @ self._on_joints)

    def _carried(self) -> tuple[NDArray[np.int64], Array]:
        """Each shape's joint among the vehicle's and then the door's, and its placement on that, (n_shapes, 4, 4)."""
        own, others = self.shapes[: self._n_vehicle], self.shapes[self._n_vehicle :]
        links = [self.vehicle.links[shape.link] for shape in own]
        links += [self.door.links[shape.link] for shape in others]
        offsets = np.repeat([0, self.vehicle.model.njoints], [len(own), len(others)])
        placements = [link.placement @ shape.placement for link, shape in zip(links, self.shapes, strict=True)]
        return offsets + [link.joint for link in links], np.array(placements)

    def _single(
        self, position: ArrayLike, rotation: ArrayLike, arm_angles: ArrayLike, door_angle: float
    ) -> tuple[Array, Array, Array, Array]:
        """One configuration as arrays of length one."""
        return self._checked(
            vector(position, 3, "position")[None],
            _numbers(rotation, "rotation_body_to_world")[None],
            vector(arm_angles, self.vehicle.n_arm, "arm_angles")[None],
            vector([door_angle], 1, "door_angle"),
        )

    def _checked(
        self, positions: ArrayLike, rotations: ArrayLike, arm_angles: ArrayLike, door_angles: ArrayLike
    ) -> tuple[Array, Array, Array, Array]:
        """Arrays of the right shapes and finite: a NaN in a pose would take the process down inside FCL."""
        p, r = _numbers(positions, "positions"), _numbers(rotations, "rotations")
        h, a = _numbers(arm_angles, "arm_angles"), _numbers(door_angles, "door_angles")
        m = len(a) if a.ndim == 1 else 0
        shapes = {
            "positions": (m, 3),
            "rotations": (m, 3, 3),
            "arm_angles": (m, self.vehicle.n_arm),
            "door_angles": (m,),
        }
        for array, (name, shape) in zip((p, r, h, a), shapes.items(), strict=True):
            if array.shape != shape or m == 0:
                raise DimensionError("wrong shape", field=name, given=array.shape, allowed=f"{shape}, at least one")
        if not np.allclose(r @ np.swapaxes(r, 1, 2), np.eye(3), atol=ROUNDED):
            raise DimensionError("not a rotation matrix", field="rotations", given=r[0].tolist(), allowed="R Rᵀ = I")
        return p, r, h, a


def _numbers(values: ArrayLike, field: str) -> Array:
    """Finite floats of any shape."""
    array = numbers(values, field)
    if not np.isfinite(array).all():
        raise DimensionError(
            "not finite", field=field, given=float(array[~np.isfinite(array)][0]), allowed="finite numbers"
        )
    return array
