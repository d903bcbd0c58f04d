"""From what a flight records to standard messages; world and body are ROS's own: z up, x forward, y left."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio
from cyclonedds.idl import IdlStruct

from doorman.arrays import Array
from doorman.exceptions import BackendError
from doorman.kinematics.rotations import quaternion_of, rotation_body_to_world
from doorman.kinematics.urdf.mesh_files import mesh_file
from doorman.kinematics.urdf.structure import check_structure
from doorman.model import Model
from doorman.ros2 import types as ros
from doorman.ros2.feed import FedMessage

WORLD = "map"
"""Frame of the world."""
DOOR = "door"
"""Prefix of the frames of the door's links, which may be named as the vehicle's."""


def description(urdf: Path) -> str:
    """Text of a URDF whose meshes any program on this computer finds."""
    root = check_structure(urdf)
    for mesh in root.iter("mesh"):
        if (file := mesh_file(urdf, mesh.get("filename", ""))) is not None:
            mesh.set("filename", file.resolve().as_uri())
    return ElementTree.tostring(root, encoding="unicode")


def _placed(stamp: IdlStruct, parent: str, name: str, placement: Array) -> IdlStruct:
    x, y, z = placement[:3, 3].tolist()
    i, j, k, w = pinocchio.Quaternion(placement[:3, :3]).coeffs().tolist()
    return ros.TransformStamped(
        ros.Header(stamp, parent), name, ros.Transform(ros.Vector3(x, y, z), ros.Quaternion(i, j, k, w))
    )


_ARROW, _ADD = 0, 0
"""Type of the marker, and what is done with it."""
_AXES = 3
_METRES_PER_NEWTON = 0.06
"""Length of the arrow of the tip's force [m/N]."""
_LINE_WIDTH = 0.02
_SIMULATED = 1_000_000_000
"""After a message of the truth, time is that of the simulation for so long [ns]."""
_SELDOM = 100_000_000
"""Between two plans, or two sets of markers, at least [ns]: they are long, and for eyes."""


class Outgoing(NamedTuple):
    topic: str  # without its prefix
    message: IdlStruct


class Translator:
    """Turns a flight's messages into those of ROS."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._base = model.vehicle.names.base_link
        self._simulated_until = -1
        self._sent: dict[str, int] = {}
        self._sizes = {"arm_angles": model.n_arm, "arm_rates": model.n_arm, "state": model.nx, "states": model.nx}

    def at_the_start(self) -> Iterator[Outgoing]:
        """What is sent once, and kept for whoever comes late."""
        yield Outgoing("/robot_description", ros.String(description(self._model.vehicle.urdf)))
        yield Outgoing("door_description", ros.String(description(self._model.door.urdf)))
        model, never = self._model, ros.Time(0, 0)
        arm, leaf = model.start_state[5:], model.start_angle
        yield Outgoing("/tf_static", ros.TFMessage(self._arm(never, arm, False) + self._leaf(never, leaf, False)))

    def translate(self, fed: FedMessage) -> Iterator[Outgoing]:
        """Messages for one of the flight's."""
        for name, value in fed.fields.items():
            size = self._sizes.get(name, _AXES)
            if isinstance(value, np.ndarray) and value.shape[-1] != size:
                raise BackendError("the flight is of another scenario", field=f"{fed.topic}.{name}",
                                   given=value.shape[-1], allowed=f"{size} numbers, as in the bridge's scenario")  # fmt: skip
        if fed.topic == "truth":
            self._simulated_until = fed.wall_time + _SIMULATED
            yield Outgoing("/clock", ros.Clock(time_of(round(1e9 * fed.time))))
            return
        simulated = fed.wall_time < self._simulated_until
        stamp = time_of(round(1e9 * fed.time) if simulated else fed.wall_time)
        match fed.topic:
            case "measurement":
                yield from self._measurement(fed.fields, stamp)
            case "estimate":
                yield from self._estimate(fed, stamp)
            case "door_sensor":
                header, names = ros.Header(stamp, WORLD), [self._model.scenario.door.hinge]
                joint = ros.JointState(header, names, [fed.fields["joint"]], [], [])
                yield Outgoing("door/measured_joint_states", joint)
            case "plan" if self._due("plan", fed.wall_time):
                yield Outgoing("plan", self._path(fed.fields["states"], stamp))
            case "mission":
                state, message = fed.fields["state"], fed.fields["message"]
                yield Outgoing("mission", ros.String(f"{state}: {message}" if message else state))

    def _arm(self, stamp: IdlStruct, angles: Array, moved: bool) -> list[IdlStruct]:
        """Transforms of the vehicle's links from its base: those that the arm's joints move, or all others."""
        vehicle = self._model.vehicle
        return [
            _placed(stamp, self._base, name, at)
            for name, at in vehicle.link_placements(angles).items()
            if name != self._base and (vehicle.links[name].joint > 0) is moved
        ]

    def _leaf(self, stamp: IdlStruct, angle: float, moved: bool) -> list[IdlStruct]:
        """Transforms of the door's links from the world: those that its joint moves, or all others."""
        door = self._model.door
        return [
            _placed(stamp, WORLD, f"{DOOR}/{name}", at)
            for name, at in door.link_placements(angle).items()
            if (door.links[name].joint > 0) is moved
        ]

    def _measurement(self, fields: Mapping[str, Any], stamp: IdlStruct) -> Iterator[Outgoing]:
        position, attitude, arm = fields["position"], fields["attitude"], fields["arm_angles"]
        turn, (x, y, z) = _rotation(attitude), position.tolist()
        velocity = rotation_body_to_world(attitude).T @ fields["velocity"]  # a twist stands in the child's frame
        header, unknown = ros.Header(stamp, WORLD), [0.0] * 36
        pose = ros.PoseWithCovariance(ros.Pose(ros.Point(x, y, z), turn), unknown)
        twist = ros.TwistWithCovariance(ros.Twist(_vector(velocity), _vector(fields["body_rates"])), unknown)
        yield Outgoing("odometry", ros.Odometry(header, self._base, pose, twist))
        if np.isfinite([*position, *attitude, *arm]).all():
            placed = ros.TransformStamped(header, self._base, ros.Transform(ros.Vector3(x, y, z), turn))
            yield Outgoing("/tf", ros.TFMessage([placed, *self._arm(stamp, arm, True)]))
        names, rates = list(self._model.vehicle.joint_names), fields["arm_rates"].tolist()
        joints = ros.JointState(ros.Header(stamp, self._base), names, arm.tolist(), rates, [])
        yield Outgoing("joint_states", joints)

    def _estimate(self, fed: FedMessage, stamp: IdlStruct) -> Iterator[Outgoing]:
        header, force = ros.Header(stamp, WORLD), fed.fields["tip_force"]
        yield Outgoing("tip_force", ros.WrenchStamped(header, ros.Wrench(_vector(force), _vector(np.zeros(3)))))
        angle, rate = fed.fields["state"][3:5].tolist()
        if not np.isfinite([angle, rate]).all():
            return
        door = self._model.door
        joint = [door.joint_value(angle)], [door.joint_rate(rate)]
        yield Outgoing("door/joint_states", ros.JointState(header, [self._model.scenario.door.hinge], *joint, []))
        yield Outgoing("/tf", ros.TFMessage(self._leaf(stamp, angle, True)))
        if self._due("markers", fed.wall_time) and np.isfinite(force).all():
            yield Outgoing("markers", ros.MarkerArray([self._arrow(header, angle, force)]))

    def _due(self, name: str, now: int) -> bool:
        """Whether it is time for the next one of what is sent seldom."""
        if now - self._sent.get(name, -_SELDOM) < _SELDOM:
            return False
        self._sent[name] = now
        return True

    def _path(self, states: Array, stamp: IdlStruct) -> IdlStruct:
        header, poses = ros.Header(stamp, WORLD), []
        for state in states:
            x, y, z = self._model.coupling.vehicle_position(state[:3], state[3], state[5:]).tolist()
            poses.append(ros.PoseStamped(header, ros.Pose(ros.Point(x, y, z), _rotation(state[:3]))))
        return ros.Path(header, poses)

    def _arrow(self, header: IdlStruct, angle: float, force: Array) -> IdlStruct:
        start = self._model.coupling.contact_point(angle)
        ends = [ros.Point(*map(float, end)) for end in (start, start + _METRES_PER_NEWTON * force)]
        nowhere = ros.Pose(ros.Point(0.0, 0.0, 0.0), ros.Quaternion(0.0, 0.0, 0.0, 1.0))
        size, nothing = ros.Vector3(_LINE_WIDTH, 2.0 * _LINE_WIDTH, 0.0), ros.Header(ros.Time(0, 0), "")
        return ros.Marker(
            header, "tip force", 0, _ARROW, _ADD, nowhere, size, ros.ColorRGBA(0.8, 0.2, 0.7, 1.0), ros.Duration(0, 0), False,
            ends, [], "", ros.CompressedImage(nothing, "", []), [], "", "", ros.MeshFile("", []), False,
        )  # fmt: skip


def time_of(wall_time: int) -> IdlStruct:
    seconds, rest = divmod(wall_time, 1_000_000_000)
    return ros.Time(seconds, rest)


def _rotation(attitude: Array) -> IdlStruct:
    roll, pitch, yaw = attitude.tolist()
    w, x, y, z = quaternion_of((roll, pitch, yaw))
    return ros.Quaternion(x, y, z, w)


def _vector(values: Array) -> IdlStruct:
    x, y, z = values.tolist()
    return ros.Vector3(x, y, z)
