"""From measurements to poses that can be believed: outliers are kept out, and what was lost is acquired again."""

from __future__ import annotations

import math

from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.datagrams.stream import Reading
from doorman.hardware.mocap.faults import FaultBook, MocapFault
from doorman.hardware.mocap.figures import Figures
from doorman.hardware.mocap.poses.sample import PoseSample, measured
from doorman.hardware.mocap.poses.velocity import TimedPose, VelocityFilter


class PoseTracker:
    """Follows the body from pose to pose.

    A pose that the motion gate lets through continues the track. When no such pose has come for `prediction_limit`, the track
    is over, and `acquire_frames` poses in a row that agree with each other begin a new one, wherever they are.

    Args:
        config: Frames and limits.
        book: Is told what is wrong.
        figures: Is told what was used.
    """

    def __init__(self, config: MocapConfig, book: FaultBook, figures: Figures) -> None:
        self._config = config
        self._book = book
        self._figures = figures
        self._alignment = config.alignment()
        self._gate = config.gate()
        self._filter = VelocityFilter(config.velocity_window)
        self._run: list[TimedPose] = []
        self._era = self._track = 0

    def take(self, reading: Reading) -> PoseSample | None:
        """Take in a measurement."""
        if reading.era != self._era:
            self._era = reading.era
            self._filter.clear()
            self._run.clear()
        pose = TimedPose(reading.frame * self._config.period,
                         *self._alignment.body_pose(reading.translation, reading.rotation))  # fmt: skip
        newest = self._filter.newest
        over = newest is None or pose.time - newest.time > self._config.prediction_limit
        if newest is not None and not over:
            too_much = self._gate.beyond_limits(newest, pose, self._filter.velocity, self._filter.lag)
            if not too_much:
                self._track += pose.time - newest.time > self._config.stale_after
                self._filter.add(pose)
                return self._sample(reading, pose)
            self._book.strike(MocapFault.OUTLIER, reading.arrival, too_much)
            return None
        self._collect(pose)
        if len(self._run) < self._config.acquire_frames:
            return None
        self._acquire(newest, reading.arrival)
        return self._sample(reading, pose)

    def _collect(self, pose: TimedPose) -> None:
        """Poses after the track, as long as they agree with each other."""
        if self._run and (
            pose.time - self._run[-1].time > self._config.prediction_limit
            or self._gate.beyond_speed(self._run[-1], pose)
        ):
            self._run.clear()
        self._run.append(pose)

    def _acquire(self, lost: TimedPose | None, now: float) -> None:
        """Begin a new track with the run of poses."""
        found = self._run[0]
        if lost is None:
            self._book.note(now, "object acquired")
        else:
            moved = (
                f"{math.dist(lost.position, found.position):.3f} m from where it was {found.time - lost.time:.2f} s ago"
            )
            if self._gate.beyond_speed(lost, found):
                self._book.strike(MocapFault.JUMPED, now, f"object acquired {moved}")
            else:
                self._book.note(now, f"object acquired again, {moved}")
        self._track += 1
        self._filter.clear()
        for pose in self._run:
            self._filter.add(pose)
        self._run.clear()

    def _sample(self, reading: Reading, pose: TimedPose) -> PoseSample:
        self._figures.pose(self._filter.lag, reading.frame_number, pose.position)
        return measured(reading.time, pose.position, pose.quaternion, self._filter.velocity, self._filter.body_rates,
                        reading.frame_number, self._figures.poses, self._track)  # fmt: skip
