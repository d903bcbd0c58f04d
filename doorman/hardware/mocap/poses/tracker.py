"""From measurements to poses that can be believed: outliers are kept out, and what was lost is acquired again."""

from __future__ import annotations

import math

from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.datagrams.stream import Reading
from doorman.hardware.mocap.faults import FaultBook, MocapFault
from doorman.hardware.mocap.figures import Figures
from doorman.hardware.mocap.poses.sample import PoseSample, measured
from doorman.hardware.mocap.poses.velocity import TimedPose, VelocityFilter
from doorman.hardware.quaternions import Vector


class PoseTracker:
    """Follows the body from pose to pose; `acquire_frames` poses that agree begin a track after `prediction_limit`."""

    def __init__(self, config: MocapConfig, book: FaultBook, figures: Figures) -> None:
        self._config = config
        self._book = book
        self._figures = figures
        self._alignment = config.alignment()
        self._gate = config.gate()
        self._filter = VelocityFilter(config.velocity_window)
        self._run: list[TimedPose] = []  # poses off the track that agree with each other
        self._leap: Vector | None = None  # by how much the first of them was off the course; None after a gap [m]
        self._shift: Vector = (0.0, 0.0, 0.0)
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
            off = self._off_course(newest, pose)
            beside = self._leap is not None and bool(self._run)
            if not too_much and not (beside and math.dist(self._run[-1].position, pose.position) < math.hypot(*off)):
                self._track += pose.time - newest.time > self._config.stale_after
                self._run.clear()
                self._filter.add(pose)
                return self._sample(reading, pose)
            self._book.strike(
                MocapFault.OUTLIER, reading.arrival, too_much or f"{math.hypot(*off):.3f} m off its course"
            )
            self._collect(pose, off if pose.time - newest.time <= self._config.stale_after else None)
            if self._leap is not None and len(self._run) >= self._config.acquire_frames:
                self._book.strike(
                    MocapFault.JUMPED, reading.arrival, f"object seen {math.hypot(*self._leap):.3f} m away at once"
                )
            return None
        self._collect(pose, None)
        begin = -math.inf if newest is None else newest.time + self._config.prediction_limit
        found = [one for one in self._run if one.time > begin]
        if len(found) < self._config.acquire_frames:
            return None
        self._acquire(newest, found[0], reading.arrival)
        return self._sample(reading, pose)

    def _off_course(self, former: TimedPose, pose: TimedPose) -> Vector:
        """From where the body would be at constant velocity to where it is seen [m]."""
        elapsed = pose.time - former.time
        x, y, z = (
            seen - place - elapsed * rate
            for seen, place, rate in zip(pose.position, former.position, self._filter.velocity, strict=True)
        )
        return (x, y, z)

    def _collect(self, pose: TimedPose, leap: Vector | None) -> None:
        """Poses off the track, as long as they agree with each other."""
        if self._run and (
            pose.time - self._run[-1].time > self._config.prediction_limit
            or self._gate.beyond_speed(self._run[-1], pose)
        ):
            self._run.clear()
        if not self._run:
            self._leap = leap
        self._run.append(pose)

    def _acquire(self, lost: TimedPose | None, found: TimedPose, now: float) -> None:
        """Begin a new track with the run of poses."""
        if self._leap is not None:
            x, y, z = (before + leap for before, leap in zip(self._shift, self._leap, strict=True))
            self._shift = (x, y, z)
        if lost is None:
            self._book.note(now, "object acquired")
        else:
            moved = (
                f"{math.dist(lost.position, found.position):.3f} m from where it was {found.time - lost.time:.2f} s ago"
            )
            if self._leap is not None or self._gate.beyond_speed(lost, found):
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
        return measured(
            reading.time, pose.position, pose.quaternion, self._filter.velocity, self._filter.body_rates,
            reading.frame_number, self._figures.poses, self._track, self._shift, reading.arrival - reading.time,
        )  # fmt: skip
