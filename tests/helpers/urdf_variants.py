"""Edited copies of the shipped URDFs, arms of any number of joints, and the vehicles of example-robot-data."""

from __future__ import annotations

import importlib.metadata
import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from doorman.resources import urdf_directory
from doorman.scenario import VehicleSection

VEHICLE = urdf_directory() / "hexarotor_arm.urdf"
DOOR = urdf_directory() / "hinged_door.urdf"


def write_edited(path: Path, source: Path, *edits: tuple[str, str]) -> Path:
    """Write a copy of a URDF with the first occurrence of each text replaced; the text must occur."""
    text = source.read_text(encoding="utf-8")
    for old, new in edits:
        assert old in text, f"{source.name} does not contain {old!r}"
        text = text.replace(old, new, 1)
    path.write_text(text, encoding="utf-8")
    return path


def write_door(
    path: Path,
    *,
    width: float = 1.2,
    height: float = 1.6,
    mass: float = 11.0,
    thickness: float = 0.04,
    damping: float = 0.0,
    friction: float = 0.0,
) -> Path:
    """Write a door whose leaf, jambs, lintel and walls fit together; the inertial is a thin plate as in the shipped one."""
    tree = ElementTree.parse(DOOR)
    frame, leaf = (_link(tree, name) for name in ("frame", "leaf"))
    top = 0.4 + height
    for shape in ("visual", "collision"):
        _place(frame, shape, "jamb_hinge", (-0.06, -0.04, (top + 0.08) / 2), (0.12, 0.08, top + 0.08))
        _place(frame, shape, "jamb_latch", (-0.06, width + 0.04, (top + 0.08) / 2), (0.12, 0.08, top + 0.08))
        _place(frame, shape, "lintel", (-0.06, width / 2, top + 0.04), (0.12, width, 0.08))
        _place(frame, shape, "sill", (-0.06, width / 2, 0.2), (0.12, width, 0.4))
        _place(frame, shape, "wall_hinge", (-0.06, -0.48, (top + 0.5) / 2), (0.08, 0.8, top + 0.5))
        _place(frame, shape, "wall_latch", (-0.06, width + 0.48, (top + 0.5) / 2), (0.08, 0.8, top + 0.5))
        _place(frame, shape, "wall_above", (-0.06, width / 2, top + 0.29), (0.08, width + 0.16, 0.42))
        _place(leaf, shape, "leaf", (width / 2, -thickness / 2, height / 2), (width, thickness, height))
    handle = _named(leaf, "visual", "handle").find("origin")
    assert handle is not None
    handle.set("xyz", _text(width - 0.08, -thickness - 0.03, 0.7))
    inertial = leaf.find("inertial")
    assert inertial is not None
    _child(inertial, "origin").set("xyz", _text(width / 2, 0.0, height / 2))
    _child(inertial, "mass").set("value", _text(mass))
    about_width, about_height = mass * height**2 / 12, mass * width**2 / 12
    for name, value in (("ixx", about_width), ("iyy", about_width + about_height), ("izz", about_height)):
        _child(inertial, "inertia").set(name, _text(value))
    dynamics = _child(_joint(tree, "hinge"), "dynamics")
    dynamics.set("damping", _text(damping))
    dynamics.set("friction", _text(friction))
    tree.write(path)
    return path


def write_arm(path: Path, *, rod: float = 0.25) -> Path:
    """Write the shipped vehicle with another distance from servo 4 to the tip."""
    tree = ElementTree.parse(VEHICLE)
    _child(_joint(tree, "tip_mount"), "origin").set("xyz", _text(rod, 0.0, 0.0))
    for shape in _link(tree, "servo_4"):
        cylinder = shape.find("geometry/cylinder")
        if cylinder is not None and cylinder.get("length") == "0.240":
            cylinder.set("length", _text(rod - 0.01))
            _child(shape, "origin").set("xyz", _text((rod - 0.01) / 2, 0.0, 0.0))
    tree.write(path)
    return path


def write_massive(
    path: Path,
    masses: Mapping[str, float],
    *,
    source: Path = VEHICLE,
    center: tuple[float, float, float] = (0.05, 0.0, 0.0),
) -> Path:
    """Write a vehicle whose links have masses [kg], each a rod of 0.1 m along x about a centre in the link's frame."""
    tree = ElementTree.parse(source)
    for name, mass in masses.items():
        inertial = ElementTree.SubElement(_link(tree, name), "inertial")
        ElementTree.SubElement(inertial, "origin", xyz=_text(*center))
        ElementTree.SubElement(inertial, "mass", value=_text(mass))
        slim, long = _text(1e-4 * mass), _text(mass * 0.1**2 / 12)
        ElementTree.SubElement(inertial, "inertia", ixx=slim, ixy="0", ixz="0", iyy=long, iyz="0", izz=long)
    tree.write(path)
    return path


def write_scaled(path: Path, source: Path, scale: float) -> Path:
    """Write a URDF with every length times a scale, mass by its cube; forces, torques and rates as gravity has them then."""
    tree = ElementTree.parse(source)
    powers = {"mass": {"value": 3.0}, "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 5.0),
              "origin": {"xyz": 1.0}, "box": {"size": 1.0}, "cylinder": {"radius": 1.0, "length": 1.0},
              "sphere": {"radius": 1.0}, "dynamics": {"damping": 4.5, "friction": 4.0}}  # fmt: skip
    for element in tree.iter():
        _scale(element, powers.get(element.tag, {}), scale)
    for joint in tree.getroot().findall("joint"):
        effort = 3.0 if joint.get("name", "").startswith("rotor") else 4.0
        for limit in joint.findall("limit"):
            _scale(limit, {"effort": effort, "velocity": -0.5}, scale)
    tree.write(path)
    return path


def _scale(element: ElementTree.Element, powers: Mapping[str, float], scale: float) -> None:
    for key, power in powers.items():
        values = [float(word) * scale**power for word in element.get(key, "").split()]
        if values:
            element.set(key, _text(*values))


def write_arm_of(path: Path, joints: int, *, odd_axes_seed: int | None = None, kinds: Mapping[int, str] = {}) -> Path:
    """Write the shipped vehicle with an arm of 0 to 7 joints, revolute where `kinds` does not say another of its index.

    By default the arm is one to fly with: a joint about −z, the others about −y, 0.5 m forward of the body at H = 0, below
    the rotors. With a seed, axes, offsets and rotations of the joints are random.
    """
    tree = ElementTree.parse(VEHICLE)
    robot = tree.getroot()
    arm = [f"servo_{k}" for k in range(1, 5)] + ["tip", "tip_mount"] + [f"eta_{k}" for k in range(1, 5)]
    for element in [item for item in robot if item.tag in ("link", "joint") and item.get("name") in arm]:
        robot.remove(element)
    offsets, turns, axes = _flyable_arm(joints) if odd_axes_seed is None else _odd_arm(joints, odd_axes_seed)
    parent = "base_link"
    for k in range(joints):
        child = f"servo_{k + 1}"
        joint = _add_joint(robot, f"eta_{k + 1}", kinds.get(k, "revolute"), parent, child, offsets[k], turns[k])
        ElementTree.SubElement(joint, "axis", xyz=_text(*axes[k]))
        ElementTree.SubElement(joint, "limit", lower="-1.8", upper="1.8", effort="3.1", velocity="3.1")
        robot.append(_centre_line(child, offsets[k + 1]))
        parent = child
    _add_joint(robot, "tip_mount", "fixed", parent, "tip", offsets[joints], turns[joints])
    ElementTree.SubElement(robot, "link", name="tip")
    tree.write(path)
    return path


def robot_data_vehicle(name: str) -> tuple[Path, VehicleSection]:
    """Path and names of a flying arm of example-robot-data: `borinot_flying_arm_2` or `hextilt_flying_arm_5`."""
    files = importlib.metadata.distribution("example-robot-data").files or []
    path = Path(str(next(file for file in files if file.name == f"{name}.urdf").locate()))
    if name == "borinot_flying_arm_2":
        names = VehicleSection(urdf=str(path), base_link="borinot__base_link", tip="flying_arm_2__ee")
    else:
        names = VehicleSection(urdf=str(path), base_link="hextilt__base_link", tip="flying_arm_5__gripper")
    return path, names


def _flyable_arm(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    offsets, axes = np.zeros((n + 1, 3)), np.tile([0.0, -1.0, 0.0], (n, 1))
    offsets[0] = [0.0, 0.0, -0.05]
    if n > 1:
        axes[0] = [0.0, 0.0, -1.0]
        offsets[1] = [0.0, 0.0, -0.04]
    forward = max(n - 2, 1)  # links that share the way ahead
    offsets[n + 1 - forward :, 0] = 0.5 / forward
    offsets[n + 1 - forward, 2] = -0.128
    return offsets, np.zeros((n + 1, 3)), axes


def _odd_arm(n: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(n, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    offsets = rng.uniform(-0.12, 0.12, (n + 1, 3)) + np.array([0.06, 0.0, -0.06])
    return offsets, rng.uniform(-math.pi, math.pi, (n + 1, 3)), axes


def _centre_line(name: str, end: np.ndarray) -> ElementTree.Element:
    """Link whose collision shape is a thin cylinder from its origin to the next joint."""
    link = ElementTree.Element("link", name=name)
    length = float(np.linalg.norm(end))
    if length > 0.0:
        pitch, yaw = math.acos(end[2] / length), math.atan2(end[1], end[0])
        collision = ElementTree.SubElement(link, "collision")
        ElementTree.SubElement(collision, "origin", xyz=_text(*(end / 2)), rpy=_text(0.0, pitch, yaw))
        geometry = ElementTree.SubElement(collision, "geometry")
        ElementTree.SubElement(geometry, "cylinder", radius="0.0004", length=_text(length))
    return link


def _add_joint(
    robot: ElementTree.Element, name: str, kind: str, parent: str, child: str, offset: np.ndarray, turn: np.ndarray
) -> ElementTree.Element:
    joint = ElementTree.SubElement(robot, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "origin", xyz=_text(*offset), rpy=_text(*turn))
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    return joint


def _place(
    link: ElementTree.Element, shape: str, name: str, center: tuple[float, ...], size: tuple[float, ...]
) -> None:
    element = _named(link, shape, name)
    _child(element, "origin").set("xyz", _text(*center))
    box = element.find("geometry/box")
    assert box is not None
    box.set("size", _text(*size))


def _link(tree: ElementTree.ElementTree, name: str) -> ElementTree.Element:
    return _named(tree.getroot(), "link", name)


def _joint(tree: ElementTree.ElementTree, name: str) -> ElementTree.Element:
    return _named(tree.getroot(), "joint", name)


def _named(parent: ElementTree.Element, tag: str, name: str) -> ElementTree.Element:
    return next(item for item in parent.findall(tag) if item.get("name") == name)


def _child(parent: ElementTree.Element, tag: str) -> ElementTree.Element:
    child = parent.find(tag)
    assert child is not None
    return child


def _text(*numbers: float) -> str:
    return " ".join(f"{number:.17g}" for number in numbers)


def write_mirrored(path: Path, source: Path) -> Path:
    """Write a URDF's mirror image, y to −y: with the hinge on the other side, if it is a door."""
    tree = ElementTree.parse(source)
    for element in tree.iter():
        if element.tag == "origin":
            x, y, z = map(float, element.get("xyz", "0 0 0").split())
            roll, pitch, yaw = map(float, element.get("rpy", "0 0 0").split())
            element.set("xyz", _text(x, -y, z))
            element.set("rpy", _text(-roll, pitch, -yaw))
        elif element.tag == "axis":
            x, y, z = map(float, element.get("xyz", "1 0 0").split())
            element.set("xyz", _text(-x, y, -z))
        elif element.tag == "inertia":
            for name in ("ixy", "iyz"):
                element.set(name, _text(-float(element.get(name, "0"))))
    tree.write(path)
    return path


def write_moved(path: Path, source: Path, position: tuple[float, float, float], yaw: float) -> Path:
    """Write a URDF whose root link stands elsewhere and is turned, on a link of its own."""
    tree = ElementTree.parse(source)
    robot = tree.getroot()
    children = {joint.find("child").get("link") for joint in robot.findall("joint")}  # type: ignore[union-attr]
    (root,) = (link.get("name") for link in robot.findall("link") if link.get("name") not in children)
    ElementTree.SubElement(robot, "link", name="elsewhere")
    joint = ElementTree.SubElement(robot, "joint", name="moved", type="fixed")
    ElementTree.SubElement(joint, "origin", xyz=_text(*position), rpy=_text(0.0, 0.0, yaw))
    ElementTree.SubElement(joint, "parent", link="elsewhere")
    ElementTree.SubElement(joint, "child", link=str(root))
    tree.write(path)
    return path
