"""Frames: where the links of vehicle and door are, as transforms of ROS, and their URDFs as ROS reads them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path

import pinocchio

from doorman.arrays import Array
from doorman.kinematics.links import Link
from doorman.kinematics.urdf.mesh_paths import mesh_file
from doorman.kinematics.urdf.structure import check_structure
from doorman.model import Model
from doorman.ros2 import types as ros

WORLD = "map"
"""Frame of the world."""
DOOR = "door"
"""Prefix of the frames of the door's links, which may be named as the vehicle's."""


class Frames:
    """Transforms of a model's links: the vehicle's from its base link, the door's from the world."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self.base = model.vehicle.names.base_link
        arm, leaf = model.start_state[5:], model.start_angle
        vehicle, door = model.vehicle.link_placements(arm), model.door.link_placements(leaf)
        vehicle.pop(self.base)
        self._arm = [name for name in vehicle if _moves(model.vehicle.links, name)]
        self._leaf = [name for name in door if _moves(model.door.links, name)]
        never = ros.Time(0, 0)
        self.standing = [
            *(self._on_base(never, name, at) for name, at in vehicle.items() if name not in self._arm),
            *(self._on_world(never, name, at) for name, at in door.items() if name not in self._leaf),
        ]
        """Transforms that never change."""

    def arm(self, stamp: ros.Time, arm_angles: Array) -> list[ros.TransformStamped]:
        """Transforms of the links that the arm's joints move."""
        placed = self._model.vehicle.link_placements(arm_angles)
        return [self._on_base(stamp, name, placed[name]) for name in self._arm]

    def leaf(self, stamp: ros.Time, door_angle: float) -> list[ros.TransformStamped]:
        """Transforms of the links that the door's joint moves."""
        placed = self._model.door.link_placements(door_angle)
        return [self._on_world(stamp, name, placed[name]) for name in self._leaf]

    def _on_base(self, stamp: ros.Time, name: str, placement: Array) -> ros.TransformStamped:
        return ros.TransformStamped(ros.Header(stamp, self.base), name, _transform(placement))

    @staticmethod
    def _on_world(stamp: ros.Time, name: str, placement: Array) -> ros.TransformStamped:
        return ros.TransformStamped(ros.Header(stamp, WORLD), f"{DOOR}/{name}", _transform(placement))


def description(urdf: Path) -> str:
    """Text of a URDF whose meshes any program on this computer finds."""
    root = check_structure(urdf)
    for mesh in root.iter("mesh"):
        if (file := mesh_file(urdf, mesh.get("filename", ""))) is not None:
            mesh.set("filename", file.resolve().as_uri())
    return ElementTree.tostring(root, encoding="unicode")


def _moves(links: Mapping[str, Link], name: str) -> bool:
    return links[name].joint > 0


def _transform(placement: Array) -> ros.Transform:
    x, y, z = placement[:3, 3].tolist()
    i, j, k, w = pinocchio.Quaternion(placement[:3, :3]).coeffs().tolist()
    return ros.Transform(ros.Vector3(x, y, z), ros.Quaternion(i, j, k, w))
