"""What a camera on the vehicle can see of the tags: those in its picture, from the front, near, with nothing before them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.door_sensor.config import CameraConfig, Mark
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.simulation.door_sensor.simulated import Seen
from doorman.simulation.plant.plant import Plant
from doorman.simulation.truth import Truth

_ASLANT = math.cos(math.radians(65.0))
"""Cosine of the angle from which on a tag is seen too flat to be read."""
_SMALLEST = 25.0
"""Edge of a tag that can still be read [pixel]."""
_BEFORE = 0.02
"""Distance before the tag from which something hides it [m]."""


class TagView:
    """What is seen in one flight."""

    def __init__(self, mujoco: Any, plant: Plant, marks: tuple[Mark, Mark], camera: CameraConfig) -> None:
        self._mujoco, self._plant, self._camera = mujoco, plant, camera
        self._marks = marks
        self._turns = tuple(rotation_body_to_world(mark.attitude) for mark in marks)
        self._axes = rotation_body_to_world(camera.attitude)

    def __call__(self, truth: Truth) -> Seen:
        """What can be seen now."""
        door = self._plant.hinge
        links = door.link_placements(truth.door_angle)[door.section.leaf], door.placement
        leaf, frame = (
            self._sees(truth, link, mark, turn)
            for link, mark, turn in zip(links, self._marks, self._turns, strict=True)
        )
        return Seen(leaf, frame)

    def _sees(self, truth: Truth, link: Array, mark: Mark, turn: Array) -> bool:
        camera = self._camera
        body = rotation_body_to_world(truth.attitude)
        eye = truth.position + body @ np.array(camera.position)
        rotation = link[:3, :3] @ turn
        middle = link[:3, 3] + link[:3, :3] @ np.array(mark.position)
        half = 0.5 * mark.size
        spots = middle + np.array([[0, 0, 0], [-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * half @ rotation.T
        ahead, left, up = ((spots - eye) @ body @ self._axes).T
        if ahead.min() < 0.05:
            return False
        columns, rows = camera.cx - camera.fx * left / ahead, camera.cy - camera.fy * up / ahead
        inside = (
            (columns > 0).all() and (columns < camera.width).all() and (rows > 0).all() and (rows < camera.height).all()
        )
        away = (eye - middle) / np.linalg.norm(eye - middle)
        if not inside or away @ rotation[:, 2] < _ASLANT or camera.fx * mark.size / ahead[0] < _SMALLEST:
            return False
        return not any(self._hidden(eye, spot) for spot in spots)

    def _hidden(self, eye: Array, spot: Array) -> bool:
        plant, way = self._plant, spot - eye
        far = float(np.linalg.norm(way))
        hit = np.zeros(1, np.int32)
        near = self._mujoco.mj_ray(
            plant.engine_model, plant.data, eye, way / far, None, 1, plant.base_body, hit
        )  # fmt: skip
        return bool(0.0 <= near < far - _BEFORE)
