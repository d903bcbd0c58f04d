"""Pictures of tags by a homography: no renderer is needed, and what they show is known exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.door_sensor.config import CameraConfig
from doorman.door_sensor.detector import dictionary, opencv
from doorman.kinematics.quaternions import to_rotation
from doorman.kinematics.rotations import rotation_body_to_world

BORDER, CELL, FINER = 1, 40, 3
"""White cells beside the black square, pixels of a cell, and by how much finer the picture is drawn before it is blurred."""
OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def picture(
    camera: CameraConfig, tags: dict[int, tuple[Any, Any]], size: float = 0.16, blur: float = 0.8, noise: float = 4.0,
    light: float = 0.9, seed: int = 0,
) -> np.ndarray:  # fmt: skip
    """What a camera sees of tags at poses (position, quaternion) in the body; blur in pixels, noise in grey levels."""
    cv = opencv()
    matrix = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
    fine = np.diag([FINER, FINER, 1.0]) @ matrix
    fine[:2, 2] += 0.5 * (FINER - 1)
    drawn = np.full((camera.height * FINER, camera.width * FINER), 120, np.uint8)
    axes, place = rotation_body_to_world(camera.attitude) @ OPTICAL, np.array(camera.position)
    for number, (position, quaternion) in tags.items():
        sheet = cv.aruco.generateImageMarker(dictionary(), number, 8 * CELL, borderBits=1)
        sheet = cv.copyMakeBorder(sheet, *[BORDER * CELL] * 4, cv.BORDER_CONSTANT, value=255)
        pixel = size / (8 * CELL)
        corner = -0.5 * size - BORDER * CELL * pixel + 0.5 * pixel
        on_paper = np.array([[pixel, 0.0, corner], [0.0, -pixel, -corner], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        rotation = axes.T @ to_rotation(quaternion)
        shift = axes.T @ (np.asarray(position, float) - place)
        homography = fine @ np.column_stack([rotation, shift]) @ on_paper
        cv.warpPerspective(sheet, homography, drawn.shape[::-1], dst=drawn, borderMode=cv.BORDER_TRANSPARENT)
    grey = cv.resize(drawn, (camera.width, camera.height), interpolation=cv.INTER_AREA)
    if blur > 0.0:
        grey = cv.GaussianBlur(grey, (0, 0), blur)
    grey = light * grey + noise * np.random.default_rng(seed).normal(size=grey.shape)
    return np.clip(grey, 0, 255).astype(np.uint8)
