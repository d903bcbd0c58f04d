r"""From measurements to poses that can be believed: outliers are kept out, and what was lost is acquired again.

Velocity and body rates: slopes of straight lines through the poses of a short window, by least squares.

.. math::
    v = \frac{\sum_i \tau_i\, P_i}{\sum_i \tau_i^2}, \qquad
    \Omega = \frac{\sum_i \tau_i \log(q_n^{-1} q_i)}{\sum_i \tau_i^2}, \qquad \tau_i = t_i - \bar t

At constant velocity they are exact, whatever poses are missing. Otherwise they are those of the window's middle: they lag by
:math:`t_n - \bar t`, half the window where no pose is missing. Noise of σ in the position gives
:math:`\sigma / \sqrt{\textstyle\sum \tau_i^2}` in the velocity.

Which poses can follow one another, by what the vehicle can do at most.

.. math::
    |\Delta P| \le n + v_{max} \Delta t, \qquad
    |\Delta P - v\,\Delta t| \le n + a_{max} \Delta t\,(\tfrac12 \Delta t + \lambda), \qquad
    \angle(q, q') \le n_q + \omega_{max} \Delta t

λ is the lag of the velocity v, in which it may have changed by a λ.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import NamedTuple

from doorman.background import EventLog
from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.faults import FaultBook, Figures, MocapEvent, MocapFault, MocapStatistics
from doorman.hardware.mocap.sample import PoseSample, measured, nothing_yet
from doorman.hardware.mocap.stream import RATE_AT_OPEN, Reading, Sender, StreamReader
from doorman.kinematics.quaternions import (
    Quaternion,
    Vector,
    angle_between,
    conjugate,
    multiply,
    rotation_vector,
)

FEWEST = 3
"""Poses that are kept however old they are."""
_TOLERANCE = 1e-9


class TimedPose(NamedTuple):
    time: float  # by the frames' own clock [s]
    position: Vector  # world frame [m]
    quaternion: Quaternion  # body to world


class VelocityFilter:
    def __init__(self, window: float) -> None:
        self._window = window
        self._poses: deque[TimedPose] = deque()
        self.velocity: Vector = (0.0, 0.0, 0.0)  # world frame [m/s]; means nothing before there are two poses
        self.body_rates: Vector = (0.0, 0.0, 0.0)  # body frame [rad/s]
        self.lag = 0.0  # between the time for which these are true and the newest pose [s]

    @property
    def newest(self) -> TimedPose | None:
        return self._poses[-1] if self._poses else None

    def clear(self) -> None:
        self._poses.clear()

    def add(self, pose: TimedPose) -> None:
        poses = self._poses
        poses.append(pose)
        while len(poses) > FEWEST and pose.time - poses[0].time > self._window + _TOLERANCE:
            poses.popleft()
        if len(poses) < 2:
            return
        mean = sum(one.time - pose.time for one in poses) / len(poses)
        back = conjugate(pose.quaternion)
        spread = 0.0
        sums = [0.0] * 6
        for time, position, quaternion in poses:
            tau = time - pose.time - mean
            spread += tau * tau
            turn = rotation_vector(multiply(back, quaternion))
            for axis in range(3):
                sums[axis] += tau * (position[axis] - pose.position[axis])
                sums[3 + axis] += tau * turn[axis]
        self.velocity = (sums[0] / spread, sums[1] / spread, sums[2] / spread)
        self.body_rates = (sums[3] / spread, sums[4] / spread, sums[5] / spread)
        self.lag = -mean


class MotionGate:
    """Limits of the vehicle's motion and of the poses' noise."""

    def __init__(self, limits: MocapConfig) -> None:
        self.limits = limits

    def beyond_speed(self, former: TimedPose, pose: TimedPose) -> str:
        """Whether the body would have had to move or turn too fast from pose to pose."""
        elapsed = pose.time - former.time
        distance = math.dist(former.position, pose.position)
        if not distance <= self.limits.position_slack + self.limits.max_speed * elapsed:
            return f"{distance:.3f} m in {1e3 * elapsed:.0f} ms"
        angle = angle_between(former.quaternion, pose.quaternion)
        if not angle <= self.limits.attitude_slack + self.limits.max_rotation_rate * elapsed:
            return f"{math.degrees(angle):.0f}° in {1e3 * elapsed:.0f} ms"
        return ""

    def beyond_limits(self, former: TimedPose, pose: TimedPose, velocity: Vector, lag: float) -> str:
        """Whether the body would have had to move, turn or speed up too much since the last pose."""
        too_fast = self.beyond_speed(former, pose)
        if too_fast:
            return too_fast
        elapsed = pose.time - former.time
        miss = math.dist(
            pose.position, [place + elapsed * rate for place, rate in zip(former.position, velocity, strict=True)]
        )
        if not miss <= self.limits.position_slack + self.limits.max_acceleration * elapsed * (0.5 * elapsed + lag):
            return f"{miss:.3f} m off its course in {1e3 * elapsed:.0f} ms"
        return ""


class PoseTracker:
    """Follows the body from pose to pose; `acquire_frames` poses that agree begin a track after `prediction_limit`."""

    def __init__(self, config: MocapConfig, book: FaultBook, figures: Figures) -> None:
        self._config = config
        self._book = book
        self._figures = figures
        self._alignment = config.alignment()
        self._gate = MotionGate(config)
        self._filter = VelocityFilter(config.velocity_window)
        self._run: list[TimedPose] = []  # poses off the track that agree with each other
        self._leap: Vector | None = None  # by how much the first of them was off the course; None after a gap [m]
        self._shift: Vector = (0.0, 0.0, 0.0)
        self._era = self._track = 0

    def take(self, reading: Reading) -> PoseSample | None:
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


class Pipeline:
    def __init__(self, config: MocapConfig, log: EventLog[MocapEvent]) -> None:
        self._config = config
        self.book = FaultBook(log, config.hold)
        self._figures = Figures()
        self._stream = StreamReader(config, self.book, self._figures)
        self._tracker = PoseTracker(config, self.book, self._figures)
        self.latest = nothing_yet()  # newest measurement; replaced as a whole

    @property
    def ready(self) -> bool:
        return self.latest.count > 0 and self._stream.monitor.near(RATE_AT_OPEN) is True

    @property
    def wrong_rate(self) -> float | None:
        """The measured rate, if it is far from the configured one [1/s]."""
        return self._stream.frame_rate if self._stream.monitor.near(RATE_AT_OPEN) is False else None

    def feed(self, datagram: bytes, sender: Sender, arrival: float, raw: float) -> None:
        reading = self._stream.read(datagram, sender, arrival, raw)
        sample = None if reading is None else self._tracker.take(reading)
        if sample is not None:
            self.latest = replace(sample, fault=self.book.holds)

    def tick(self, now: float) -> None:
        self._stream.tick(now)
        if self.latest.count:
            age = now - self.latest.time
            limits = (
                (MocapFault.STALE, self._config.stale_after),
                (MocapFault.LOST, self._config.prediction_limit),
            )
            for fault, limit in limits:
                self.book.keep(fault, age > limit, now, f"no pose for {1e3 * limit:.0f} ms" if age > limit else "")
        self.book.tick(now)
        if self.latest.fault != self.book.holds:
            self.latest = replace(self.latest, fault=self.book.holds)

    def deadline(self, now: float) -> float:
        """When `tick` must be called next if nothing comes [s]; ∞ if there is nothing to wait for."""
        ages = (self._config.stale_after, self._config.prediction_limit) if self.latest.count else ()
        times = (*(self.latest.time + age for age in ages), self._stream.deadline, self.book.deadline)
        return min((time for time in times if time > now), default=math.inf)

    def diagnosis(self) -> str:
        return self._stream.diagnosis()

    def statistics(self) -> MocapStatistics:
        return self._figures.statistics(self.book.counts, self._stream.frame_rate, self._config.latency)
