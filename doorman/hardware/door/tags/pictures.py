"""Pictures of a camera: whatever callable takes them, or a V4L2 device by OpenCV."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import BackendError
from doorman.hardware.door.config import CameraConfig
from doorman.hardware.door.tags.detector import opencv


class Picture(NamedTuple):
    """One picture."""

    time: float  # when it was exposed, by `time.monotonic` [s]
    grey: NDArray[np.uint8]  # shape (height, width)


Pictures = Callable[[], Picture | None]
"""Waits for the next picture and returns it, or None for none yet. It is called in the detector's process: it must be importable
there, and open its camera at the first call."""


class Video:
    """A V4L2 device. Opens at the first call."""

    def __init__(self, camera: CameraConfig) -> None:
        self._camera, self._capture = camera, None

    def __call__(self) -> Picture:
        """Next picture."""
        cv, camera = opencv(), self._camera
        capture = self._capture or self._opened(cv)
        good, picture = capture.read()
        now = time.monotonic()
        if not good:
            raise BackendError("the camera brings no pictures", field="door_sensor.camera.device", given=camera.device)
        grey = picture if picture.ndim == 2 else cv.cvtColor(picture, cv.COLOR_BGR2GRAY)
        if grey.shape != (camera.height, camera.width):
            raise BackendError("the camera has another size", field="door_sensor.camera.width", given=grey.shape[::-1],
                               allowed=f"{camera.width} x {camera.height}")  # fmt: skip
        return Picture(now - camera.latency, grey)

    def _opened(self, cv: Any) -> Any:
        camera = self._camera
        device: str | int = int(camera.device) if camera.device.isdecimal() else camera.device
        capture = cv.VideoCapture(device, cv.CAP_V4L2)
        if not capture.isOpened():
            raise BackendError("cannot open the camera", field="door_sensor.camera.device", given=camera.device,
                               allowed="a V4L2 device that this user may read")  # fmt: skip
        for key, value in (
            (cv.CAP_PROP_FRAME_WIDTH, camera.width), (cv.CAP_PROP_FRAME_HEIGHT, camera.height),
            (cv.CAP_PROP_FPS, camera.rate), (cv.CAP_PROP_BUFFERSIZE, 1),
        ):  # fmt: skip
            capture.set(key, value)
        self._capture = capture
        return capture
