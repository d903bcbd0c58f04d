r"""Poses of AprilTags (36h11) in a picture: OpenCV finds them, lines along their edges place their corners, and a pose follows.

OpenCV's corners are off by a few tenths of a pixel where the picture is blurred. So each edge is found again: along its normal,
at 24 places, the middle of the step from black to white. A line through these is exact to some hundredths of a pixel, and the
corners are where lines meet. This makes the place five to ten times better than `cv2.cornerSubPix`, for a millisecond.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.door_sensor.config import CameraConfig, DoorSensorConfig
from doorman.door_sensor.sensor import DoorSample, FrameSample, LeafSample, MarkPose
from doorman.exceptions import BackendError, how_to_install
from doorman.kinematics.quaternions import from_rotation, to_rotation
from doorman.kinematics.rotations import rotation_body_to_world

_PLACES = np.linspace(0.12, 0.88, 24)
"""Along an edge, where it is looked for: its ends are rounded by blur."""
_REACHES = (4.0, 2.0)
"""Way on either side on which the step is looked for, at the first and the second pass [pixel]."""
_STEPS = 13
_FAINT = 0.15
"""Share of an edge's steepest place below which a slope is noise."""
_STRAY = 2.5
"""Deviations by which a place is off its line before it is left out: where something lies over the edge."""
_LEAST_EDGE = 3 * max(_REACHES)
"""Shorter edges have no room for this [pixel]."""
_WINDOW = 33
"""Edge of the square whose mean black is darker than [pixel], wider than a cell of a tag that fills half the picture. OpenCV's
three windows find no more tags, and take three times as long."""
_OPTICAL = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
"""Rotation from a camera's optical axes (right, down, ahead) to axes that look along x (ahead, left, up)."""


@dataclass(frozen=True)
class SeenTag:
    corners: Array  # of its black square, from the upper left one clockwise as it is printed, shape (4, 2) [pixel]
    pose: MarkPose  # in the vehicle's body


class TagDetector:
    def __init__(self, camera: CameraConfig, sizes: dict[int, float]) -> None:
        self._cv = cv = opencv()
        self._sizes = sizes
        parameters = cv.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv.aruco.CORNER_REFINE_NONE
        parameters.adaptiveThreshWinSizeMin = parameters.adaptiveThreshWinSizeMax = _WINDOW
        self._detector = cv.aruco.ArucoDetector(dictionary(), parameters)
        self._matrix = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
        self._distortion = np.array(camera.distortion, float) if camera.distortion else None
        self._position = np.array(camera.position)
        self._axes = rotation_body_to_world(camera.attitude) @ _OPTICAL

    def detect(self, picture: NDArray[np.uint8]) -> dict[int, SeenTag]:
        found, numbers, _ = self._detector.detectMarkers(picture)
        seen: dict[int, SeenTag] = {}
        numbers = [] if numbers is None else [int(one) for one in np.ravel(numbers)]
        for number, quad in zip(numbers, found, strict=True):
            if number in self._sizes and numbers.count(number) == 1:
                corners = self._refined(picture, np.asarray(quad, float).reshape(4, 2))
                if (pose := self._pose(corners, self._sizes[number])) is not None:
                    seen[number] = SeenTag(corners, pose)
        return seen

    def _refined(self, picture: NDArray[np.uint8], corners: Array) -> Array:
        grey = picture.astype(np.float32)
        for reach in _REACHES:
            if np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1).min() < _LEAST_EDGE:
                return corners
            corners = self._on_edges(grey, corners, reach)
        return corners

    def _on_edges(self, grey: NDArray[np.float32], corners: Array, reach: float) -> Array:
        """Where lines along the four edges meet."""
        along = np.roll(corners, -1, axis=0) - corners
        normals = np.stack([along[:, 1], -along[:, 0]], 1) / np.linalg.norm(along, axis=1)[:, None]
        ways = np.linspace(-reach, reach, _STEPS)
        at = (
            corners[:, None, None]
            + _PLACES[:, None, None] * along[:, None, None]
            + ways[:, None] * normals[:, None, None]
        )
        flat = at.reshape(4 * len(_PLACES), _STEPS, 2).astype(np.float32)
        values = self._cv.remap(grey, flat[..., 0], flat[..., 1], self._cv.INTER_LINEAR).reshape(at.shape[:3])
        brighter = np.sign((values[..., -1] - values[..., 0]).mean())
        slopes = np.clip(brighter * np.diff(values, axis=2), 0.0, None)
        slopes = np.where(slopes > _FAINT * slopes.max(axis=2, keepdims=True), slopes, 0.0)
        offsets = (slopes * (0.5 * (ways[1:] + ways[:-1]))).sum(axis=2) / np.maximum(slopes.sum(axis=2), 1e-6)
        design = np.stack([np.ones_like(_PLACES), _PLACES], 1)
        lines = np.array([_line(design, each) for each in offsets])
        ends = np.stack([lines[:, 0], lines.sum(axis=1)], 1)
        first, last = (p + normals * ends[:, k, None] for k, p in enumerate((corners, corners + along)))
        return np.array([_meeting(first[k - 1], last[k - 1], first[k], last[k]) for k in range(4)])

    def _pose(self, corners: Array, size: float) -> MarkPose | None:
        cv, half = self._cv, 0.5 * size
        square = np.array([[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]])
        good, turns, places, _ = cv.solvePnPGeneric(
            square, corners, self._matrix, self._distortion, flags=cv.SOLVEPNP_IPPE_SQUARE
        )
        if not good:
            return None
        turn, place = cv.solvePnPRefineLM(square, corners, self._matrix, self._distortion, turns[0], places[0])
        rotation = self._axes @ cv.Rodrigues(turn)[0]
        x, y, z = (self._position + self._axes @ place.ravel()).tolist()
        return MarkPose((x, y, z), from_rotation(rotation), in_body=True)


def opencv() -> Any:
    """OpenCV, on one core."""
    try:
        import cv2
    except ImportError as error:
        raise BackendError(f"tags need OpenCV; {how_to_install('tags')}", field="door_sensor.source") from error
    cv2.setNumThreads(1)
    return cv2


def dictionary() -> Any:
    """AprilTags 36h11."""
    cv = opencv()
    return cv.aruco.getPredefinedDictionary(cv.aruco.DICT_APRILTAG_36h11)


def _line(design: Array, offsets: Array) -> Array:
    """Offset at the edge's beginning and its growth to the end, without strays."""
    line = np.linalg.lstsq(design, offsets)[0]
    rest = np.abs(offsets - design @ line)
    kept = rest < _STRAY * 1.4826 * np.median(rest) + 0.05
    return np.asarray(np.linalg.lstsq(design[kept], offsets[kept])[0])


def _meeting(a: Array, b: Array, c: Array, d: Array) -> Array:
    share = np.linalg.solve(np.array([b - a, c - d]).T, c - a)[0]
    return np.asarray(a + share * (b - a))


class DoorByTags:
    def __init__(self, config: DoorSensorConfig) -> None:
        self._marks = config.marks
        self._mounts = {
            part: (np.array(mark.position), rotation_body_to_world(mark.attitude)) for part, mark in self._marks.items()
        }

    def sample(self, time: float, seen: dict[int, MarkPose], before: DoorSample) -> DoorSample:
        """What the tags of one picture say; what is not in it stays as before."""
        links = {part: self._link(part, seen[mark.tag]) for part, mark in self._marks.items() if mark.tag in seen}
        return DoorSample(
            LeafSample(time, pose=links["leaf"]) if "leaf" in links else before.leaf,
            FrameSample(time, links["frame"]) if "frame" in links else before.frame,
        )

    def _link(self, part: str, tag: MarkPose) -> MarkPose:
        """Pose of the link that a tag is stuck on."""
        place, turn = self._mounts[part]
        rotation = to_rotation(tag.quaternion) @ turn.T
        x, y, z = (np.array(tag.position) - rotation @ place).tolist()
        return MarkPose((x, y, z), from_rotation(rotation), in_body=True)
