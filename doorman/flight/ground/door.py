"""Rows of the checklist about a sensor of the door: where it has frame and leaf, against the map."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from doorman.clocks import BRIEFLY
from doorman.control.estimation.door_watch import DoorWatch
from doorman.exceptions import BackendError
from doorman.flight.ground.judgements import Check, Verdict, row
from doorman.hardware.door import DoorSensor
from doorman.hardware.vehicle import VehicleLinks
from doorman.hardware.vehicle.waiting import LISTENING
from doorman.model import Model
from doorman.signals import FrameReading, LeafReading

_NEAR, _TURNED = 0.01, math.radians(1.0)
"""Error of the map that is not reported [m], [rad]."""
_AJAR = 3 * _TURNED
"""Difference from its start at which a leaf counts as ajar [rad]."""


def measured_door(model: Model, links: VehicleLinks) -> Iterator[Check]:
    """Rows about frame and leaf; none without a sensor."""
    if links.door is None:
        return
    leaf, frame = mean_readings(links)
    config = links.door.config
    words = "; ".join(said for _, said in links.door.events()[-2:]) or "no reading"
    if frame is not None:
        yield _frame(model, frame)
    elif config.frame is not None:
        yield Check("door's frame", Verdict.WARNING, words,
                    "show the frame's mark to the sensor, or fly without: the map counts")  # fmt: skip
    if leaf is not None:
        yield _leaf(model, leaf)
    elif config.leaf is not None or config.frame is None:
        yield Check("leaf", Verdict.WARNING, words,
                    "show the leaf's mark to the sensor, or fly without: the tip finds the leaf")  # fmt: skip


def mean_readings(links: VehicleLinks, duration: float = LISTENING) -> tuple[LeafReading | None, FrameReading | None]:
    """Means of what a sensor of the door says for a while, the vehicle at rest; none where it says nothing."""
    if links.door is None:
        raise BackendError("there is no sensor of the door", field="door_sensor", allowed="in the vehicle file")
    leaves: list[LeafReading] = []
    frames: list[FrameReading] = []
    end = links.clock.now() + duration
    while (now := links.clock.now()) < end:
        _note_pose(links, links.door)
        leaf, frame = links.door.read(now)
        if leaf is not None and (not leaves or leaf.time != leaves[-1].time):
            leaves.append(leaf)
        if frame is not None and (not frames or frame.time != frames[-1].time):
            frames.append(frame)
        links.clock.sleep(BRIEFLY)
    mean_leaf = mean_frame = None
    if leaves:
        mean_leaf = replace(leaves[-1], joint=float(np.mean([one.joint for one in leaves])))
    if frames:
        position, yaw = np.mean([one.position for one in frames], axis=0), float(np.mean([one.yaw for one in frames]))
        mean_frame = replace(frames[-1], position=position, yaw=yaw)
    return mean_leaf, mean_frame


def _note_pose(links: VehicleLinks, sensor: DoorSensor) -> None:
    """Where the vehicle is, for what its own camera sees."""
    if links.mocap is None:
        state = links.autopilot.state()
        at, position, attitude = state.position_time, state.position, state.attitude
    else:
        pose = links.mocap.read()
        at, position, attitude = pose.time, pose.position, pose.attitude
    if np.isfinite(position).all() and np.isfinite(attitude).all():
        sensor.note_pose(at, position, attitude)


def _frame(model: Model, frame: FrameReading) -> Check:
    watch = DoorWatch(model)
    found = watch.moves(frame)
    x, y, z = frame.position.tolist()
    numbers = f"door.position = [{x:.3f}, {y:.3f}, {z:.3f}], door.yaw = {frame.yaw:.4f}"
    advice = f"doorman vehicle door writes what is measured into the task: {numbers}"
    if found is None:
        return Check("door's frame", Verdict.BAD, watch.refused, advice)
    off, turned = float(np.hypot(*found[0])), abs(found[1])
    return row("door's frame", off < _NEAR and turned < _TURNED,
               f"measured {1e2 * off:.1f} cm and {math.degrees(turned):.1f}° beside the map; the flight takes the measured place",
               advice, Verdict.WARNING)  # fmt: skip


def _leaf(model: Model, leaf: LeafReading) -> Check:
    door, angle = model.door, model.door.angle_of_joint(leaf.joint)
    found = f"measured at {door.in_words(angle)}, the task begins at {door.in_words(model.start_angle)}"
    return row("leaf", abs(angle - model.start_angle) < _AJAR, found,
               "shut the door, or fly: the vehicle goes to where the leaf is", Verdict.WARNING)  # fmt: skip
