"""Tags: how well they are seen by distance, angle, blur and light; their process; and their paper."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from tag_pictures import picture

from doorman.door_sensor.detector import TagDetector
from doorman.door_sensor.printing import Page, tag_cells, tag_pdf
from doorman.exceptions import BackendError
from doorman.hardware.door import CameraConfig, DoorSample, DoorSensorConfig, Mark
from doorman.hardware.door.tags import DoorByTags, Picture, TagSource
from doorman.kinematics.quaternions import from_rotation, multiply, to_rotation
from doorman.kinematics.rotations import rotation_body_to_world

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
