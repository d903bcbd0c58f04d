"""Tags: how well they are seen by distance, angle, blur and light; their process; and their paper.

Pictures of tags are made by a homography: no renderer is needed, and what they show is known exactly.
"""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pytest

from doorman.door_sensor.detector import TagDetector, dictionary, opencv
from doorman.door_sensor.printing import Page, tag_cells, tag_pdf
from doorman.exceptions import BackendError
from doorman.hardware.door import CameraConfig, DoorSample, DoorSensorConfig, Mark
from doorman.hardware.door.tags import DoorByTags, Picture, TagSource
from doorman.kinematics.quaternions import from_rotation, multiply, to_rotation
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


CAMERA = CameraConfig()
FACING = from_rotation(np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
"""Of a tag that looks back at the vehicle: its x to the vehicle's right, its z towards it."""


def turned(angle: float) -> tuple[float, float, float, float]:
    """A tag turned about the vertical."""
    return multiply((math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle)), FACING)


def seen(distance: float, angle: float, **looks) -> tuple[float, float] | None:
    """How far off a tag is seen: place [m], and attitude [rad]."""
    place, quaternion = np.array([CAMERA.position[0] + distance, 0.05, -0.04]), turned(angle)
    found = TagDetector(CAMERA, {3: 0.16}).detect(picture(CAMERA, {3: (place, quaternion)}, **looks))
    if 3 not in found:
        return None
    pose = found[3].pose
    off = to_rotation(pose.quaternion).T @ to_rotation(quaternion)
    return float(np.linalg.norm(pose.position - place)), math.acos(min(0.5 * (np.trace(off) - 1.0), 1.0))


@pytest.mark.parametrize(
    ("distance", "angle", "looks", "most"),
    [
        (0.4, 0.1, {}, 0.0015),
        (0.65, 0.4, {}, 0.0015),
        (0.9, -0.4, {}, 0.003),
        (1.5, 0.2, {}, 0.02),
        (0.65, 0.9, {}, 0.003),
        (0.65, 0.2, {"blur": 2.0}, 0.004),
        (0.65, 0.2, {"light": 0.25}, 0.004),
    ],
    ids=["near", "usual", "far", "very far", "aslant", "blurred", "dark"],
)
def test_a_tag_is_seen_where_it_is(distance, angle, looks, most):
    errors = [seen(distance, angle, seed=seed, **looks) for seed in range(3)]
    assert all(each is not None and each[0] < most and each[1] < math.radians(4.0) for each in errors), errors


def test_what_is_not_there_or_twice_is_not_seen():
    detector = TagDetector(CAMERA, {3: 0.16})
    assert detector.detect(picture(CAMERA, {})) == {}
    assert detector.detect(picture(CAMERA, {4: ((0.7, 0.0, 0.0), FACING)})) == {}
    both = picture(CAMERA, {3: ((0.9, 0.25, 0.0), FACING)})
    both[:, 320:] = picture(CAMERA, {3: ((0.9, -0.25, 0.0), FACING)})[:, 320:]
    assert detector.detect(both) == {}


def test_the_leafs_link_follows_from_its_tag():
    mark = Mark("3", position=(0.3, 0.02, 1.0), attitude=(0.2, -0.1, 0.4))
    config = DoorSensorConfig(source="tags", leaf=mark)
    place, turn = np.array([0.8, 0.1, -0.2]), rotation_body_to_world((0.1, 0.2, 0.3))
    tag = place + turn @ np.array(mark.position), turn @ rotation_body_to_world(mark.attitude)
    from doorman.door_sensor.sensor import MarkPose

    pose = MarkPose(tuple(tag[0].tolist()), from_rotation(tag[1]), in_body=True)
    sample = DoorByTags(config).sample(5.0, {3: pose}, DoorSample())
    assert sample.frame is None and sample.leaf.time == 5.0
    assert DoorByTags(config).sample(6.0, {}, sample) == sample, "what is not in a picture stays as before"
    np.testing.assert_allclose(sample.leaf.pose.position, place, atol=1e-12)
    np.testing.assert_allclose(to_rotation(sample.leaf.pose.quaternion), turn, atol=1e-12)


class Film:
    """Pictures of a tag, taken in the detector's process."""

    def __init__(self, last: int) -> None:
        self.left = last

    def __call__(self) -> Picture:
        self.left -= 1
        if self.left < 0:
            raise OSError("the film has ended")
        return Picture(time.monotonic(), picture(CAMERA, {3: ((0.8, 0.1, 0.0), FACING)}))


def test_the_detectors_process_tells_poses_then_why_it_ended():
    source = TagSource(DoorSensorConfig(source="tags", leaf=Mark("3")), Film(2))
    with pytest.raises(BackendError, match="not open"):
        source.read()
    source.open()
    try:
        end, sample, words = time.monotonic() + 60.0, DoorSample(), ""
        while time.monotonic() < end and not words:
            try:
                sample = source.read()
            except BackendError as error:
                words = str(error)
            time.sleep(0.005)
        assert "the film has ended" in words
        np.testing.assert_allclose((source._newest.leaf or sample.leaf).pose.position, (0.8, 0.1, 0.0), atol=0.003)
    finally:
        source.stop()
        source.stop()


def test_a_printed_tag_has_its_size_and_its_cells():
    pdf = tag_pdf([Page(Mark("7", size=0.12), ("on the leaf (left)",)), Page(Mark("8"), ())])
    text = pdf.decode("latin-1")
    assert text.count("/Type /Page ") == 2 and r"on the leaf \(left\)" in text
    squares = [line.split() for line in text.splitlines() if line.endswith("15.000 15.000 re f")]
    assert len(squares) == tag_cells(7).sum() and tag_cells(7)[0].all()
    xs = [float(one[0]) for one in squares]
    assert max(xs) - min(xs) + 15.0 == pytest.approx(120.0)
    for offset in [line.split()[0] for line in text[text.index("xref") :].splitlines()[3:-4]]:
        assert pdf[int(offset) :].split(b" ", 1)[1].startswith(b"0 obj")
    with pytest.raises(BackendError, match="larger than the paper"):
        tag_pdf([Page(Mark("7", size=0.3), ())])
