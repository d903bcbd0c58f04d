"""Leaf and frame by their tags: a process of its own takes pictures and finds tags, and sends their poses.

The process gives up the real-time scheduling of the flight that starts it, and uses one core: the controller does not wait for
it. One that ends is started again.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.clocks import RESTART
from doorman.copying import Uncopied
from doorman.door_sensor.config import CameraConfig, DoorSensorConfig
from doorman.door_sensor.detector import DoorByTags, TagDetector, opencv
from doorman.door_sensor.sensor import DoorSample, MarkPose
from doorman.exceptions import BackendError


class Picture(NamedTuple):
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


_Found = tuple[float, dict[int, MarkPose]]


class TagSource(Uncopied):
    """A `DoorSource` by tags. The constructor starts nothing."""

    def __init__(self, config: DoorSensorConfig, pictures: Pictures | None = None) -> None:
        camera = config.camera or CameraConfig()
        self._camera, self._pictures = camera, pictures or Video(camera)
        self._sizes = {mark.tag: mark.size for mark in config.marks.values()}
        self._door, self._newest = DoorByTags(config), DoorSample()
        self._process: BaseProcess | None = None
        self._link: Connection | None = None
        self._started, self._words = 0.0, ""

    def open(self) -> None:
        if self._process is not None:
            raise BackendError("the source is open already", allowed="stop() before another open()")
        TagDetector(self._camera, self._sizes)  # says what is missing, before anything flies
        self._newest, self._words = DoorSample(), ""
        self._start()

    def read(self) -> DoorSample:
        if self._process is None or self._link is None:
            raise BackendError("the source is not open", allowed="open() before read()")
        try:
            while self._link.poll():
                found: _Found | str = self._link.recv()
                if isinstance(found, str):
                    self._words = found
                else:
                    self._newest, self._words = self._door.sample(*found, self._newest), ""
            alive = self._process.is_alive()
        except (EOFError, OSError):
            alive = False
        if not alive:
            self._words = self._words or "the detector's process has ended"
            if time.monotonic() - self._started > RESTART:
                self._end()
                self._start()
        if self._words:
            raise BackendError(self._words, field="door_sensor")
        return self._newest

    def stop(self) -> None:
        self._end()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._link, theirs = context.Pipe(duplex=False)
        self._process = context.Process(
            target=_run, args=(self._camera, self._sizes, self._pictures, theirs), name="tags", daemon=True
        )
        self._process.start()
        theirs.close()
        self._started = time.monotonic()

    def _end(self) -> None:
        process, link, self._process, self._link = self._process, self._link, None, None
        if process is not None:
            process.terminate()
            process.join(RESTART)
        if link is not None:
            link.close()


def _run(camera: CameraConfig, sizes: dict[int, float], pictures: Pictures, link: Connection) -> None:
    if hasattr(os, "sched_setscheduler"):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    parent = os.getppid()
    try:
        detector = TagDetector(camera, sizes)
        while os.getppid() == parent:
            if (picture := pictures()) is not None:
                link.send((picture.time, {number: tag.pose for number, tag in detector.detect(picture.grey).items()}))
    except (KeyboardInterrupt, BrokenPipeError):
        return
    except Exception as error:  # whatever it is: the parent tells it
        link.send(f"{type(error).__name__}: {error}")
