"""Pinocchio's model of a URDF, its frames and links: one place where a broken file becomes a clear error."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio

from doorman.arrays import Array, frozen
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.document import read_content
from doorman.kinematics.urdf.structure import check_structure

_BROKEN_NAME = re.compile(rb"""\sname\s*=\s*(?:"([^"]*[\t\r\n][^"]*)"|'([^']*[\t\r\n][^']*)')""")
"""XML makes spaces of its blanks, and readers disagree on them."""


class Link(NamedTuple):
    """A link as its joint carries it."""

    joint: int
    """Index of the joint in Pinocchio's model; 0 is the root."""
    placement: Array
    """Homogeneous matrix of the link in the joint's frame, shape (4, 4)."""


def load_pinocchio(path: Path, endless: bool = True) -> pinocchio.Model:
    """Kinematic tree of a URDF whose root link is fixed in the world."""
    root = check_structure(path)
    if not endless:
        _make_revolute(root)
    try:
        model = pinocchio.buildModelFromXML(ElementTree.tostring(root, encoding="unicode"))  # what was checked
    except (ValueError, RuntimeError) as error:
        raise UrdfError(
            "not a valid URDF",
            file=path,
            field="/robot",
            given=" ".join(str(error).split()) or type(error).__name__,
            allowed="a URDF that Pinocchio reads",
        ) from error
    if broken := _BROKEN_NAME.search(read_content(path)):
        raise UrdfError(
            "a name contains a line break or a tab", file=path, field="/robot",
            given=repr((broken[1] or broken[2]).decode(errors="replace")), allowed="names without",
        )  # fmt: skip
    return model


def with_standing(full: pinocchio.Model, standing: list[int], places: Array) -> pinocchio.Model:
    """A model whose joints stand at places; Pinocchio looks for their frames by name, and a link may have the same."""
    links = {frame.name for frame in full.frames if frame.type == pinocchio.FrameType.BODY}
    for frame in full.frames:
        if frame.type == pinocchio.FrameType.JOINT and frame.parentJoint in standing and frame.name in links:
            frame.name = full.names[frame.parentJoint] = f"{frame.name} (joint)"
    return pinocchio.buildReducedModel(full, standing, places) if standing else full


def frame_index(model: pinocchio.Model, name: str, path: Path, field: str) -> int:
    """Index of a frame that must exist."""
    if not model.existFrame(name):
        names = ", ".join(dict.fromkeys(frame.name for frame in model.frames if frame.name != "universe"))
        raise UrdfError(f"the URDF has no link or joint '{name}'", file=path, field=field, given=name, allowed=names)
    body = pinocchio.FrameType.BODY  # a joint may carry the same name as its link
    return int(model.getFrameId(name, body) if model.existFrame(name, body) else model.getFrameId(name))


def link_index(model: pinocchio.Model, name: str, path: Path, field: str) -> int:
    """Index of the frame of a link that must exist, and must not be a joint."""
    body = pinocchio.FrameType.BODY
    if not model.existFrame(name, body):
        names = ", ".join(frame.name for frame in model.frames if frame.type == body)
        raise UrdfError(f"the URDF has no link '{name}'", file=path, field=field, given=name, allowed=names)
    return int(model.getFrameId(name, body))


def links_of(model: pinocchio.Model) -> dict[str, Link]:
    """Links by name."""
    return {
        frame.name: Link(int(frame.parentJoint), frozen(frame.placement.homogeneous))
        for frame in model.frames
        if frame.type == pinocchio.FrameType.BODY
    }


def joint_placements_along(model: pinocchio.Model, data: pinocchio.Data, values: Array) -> Array:
    """Placements of all joints at each of m configurations, by forward kinematics."""
    placements = np.empty((len(values), model.njoints, 4, 4))
    for at, configuration in zip(placements, values, strict=True):
        pinocchio.forwardKinematics(model, data, configuration)
        for joint, placement in enumerate(data.oMi):
            at[joint] = placement.homogeneous
    return placements


def _make_revolute(root: ElementTree.Element) -> None:
    """Give the continuous joints of a URDF one coordinate; one without `<limit>` cannot move."""
    for joint in (joint for joint in root.findall("joint") if joint.get("type") == "continuous"):
        joint.set("type", "revolute")
        limit = joint.find("limit")
        if limit is None:
            limit = ElementTree.SubElement(joint, "limit", effort="0", velocity="0")
        limit.set("lower", "-1e6")
        limit.set("upper", "1e6")
