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
from operator import add, mul, sub
from typing import NamedTuple

from doorman.background import EventLog
from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.faults import FaultBook, Figures, MocapEvent, MocapFault, MocapStatistics
from doorman.hardware.mocap.sample import PoseSample, measured, nothing_yet
from doorman.hardware.mocap.stream import RATE_AT_OPEN, Reading, Sender, StreamReader
from doorman.kinematics.quaternions import Quaternion, Vector, angle_between, conjugate, multiply, rotation_vector

FEWEST = 3
"""Poses that are kept however old they are."""


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
        while len(poses) > FEWEST and pose.time - poses[0].time > self._window + 1e-9:
            poses.popleft()
        if len(poses) < 2:
            return
        ages = [pose.time - one.time for one in poses]
        self.lag = sum(ages) / len(ages)
        taus, back = [self.lag - age for age in ages], conjugate(pose.quaternion)
        self.velocity = _slope(taus, [tuple(map(sub, one.position, pose.position)) for one in poses])
        self.body_rates = _slope(taus, [rotation_vector(multiply(back, one.quaternion)) for one in poses])


def _slope(taus: list[float], rows: list[tuple[float, ...]]) -> Vector:
    spread = sum(tau * tau for tau in taus)
    x, y, z = (sum(map(mul, taus, column)) / spread for column in zip(*rows, strict=True))
    return (x, y, z)


def too_fast(limits: MocapConfig, former: TimedPose, pose: TimedPose) -> str:
    """How the body would have had to move or turn faster than it can from pose to pose; nothing if it would not."""
    elapsed = pose.time - former.time
    distance = math.dist(former.position, pose.position)
    if not distance <= limits.position_slack + limits.max_speed * elapsed:
        return f"{distance:.3f} m in {1e3 * elapsed:.0f} ms"
    angle = angle_between(former.quaternion, pose.quaternion)
    if not angle <= limits.attitude_slack + limits.max_rotation_rate * elapsed:
        return f"{math.degrees(angle):.0f}° in {1e3 * elapsed:.0f} ms"
    return ""


def impossible(limits: MocapConfig, former: TimedPose, pose: TimedPose, miss: float, lag: float) -> str:
    """How the body would have had to move, turn or speed up too much since the last pose, by what it missed its course."""
    elapsed = pose.time - former.time
    if miss <= limits.position_slack + limits.max_acceleration * elapsed * (0.5 * elapsed + lag):
        return too_fast(limits, former, pose)
    return too_fast(limits, former, pose) or f"{miss:.3f} m off its course in {1e3 * elapsed:.0f} ms"


class PoseTracker:
    """Follows the body from pose to pose; `acquire_frames` poses that agree begin a track after `prediction_limit`."""

    def __init__(self, config: MocapConfig, book: FaultBook, figures: Figures) -> None:
        self._config, self._book, self._figures = config, book, figures
        self._alignment = config.alignment()
        self._filter = VelocityFilter(config.velocity_window)
        self._run: list[TimedPose] = []  # poses off the track that agree with each other
        self._leap: Vector | None = None  # by how much the first of them was off the course; None after a gap [m]
        self._shift: Vector = (0.0, 0.0, 0.0)
        self._era = self._track = 0

    def take(self, reading: Reading) -> PoseSample | None:
        config, now = self._config, reading.arrival
        if reading.era != self._era:
            self._era = reading.era
            self._filter.clear()
            self._run.clear()
        pose = TimedPose(
            reading.frame * config.period, *self._alignment.body_pose(reading.translation, reading.rotation)
        )
        last = self._filter.newest
        if last is None or pose.time - last.time > config.prediction_limit:
            self._collect(pose, None)
            return self._sample(reading, pose) if self._acquire(last, now) else None
        off = self._off_course(last, pose)
        miss, seamless = math.hypot(*off), pose.time - last.time <= config.stale_after
        why = impossible(config, last, pose, miss, self._filter.lag)
        leaps = self._leap is not None and bool(self._run) and math.dist(self._run[-1].position, pose.position) < miss
        if not why and not leaps:
            self._track += not seamless
            self._run.clear()
            self._filter.add(pose)
            return self._sample(reading, pose)
        self._book.strike(MocapFault.OUTLIER, now, why or f"{miss:.3f} m off its course")
        self._collect(pose, off if seamless else None)
        if self._leap is not None and len(self._run) >= config.acquire_frames:
            self._book.strike(MocapFault.JUMPED, now, f"object seen {math.hypot(*self._leap):.3f} m away at once")
        return None

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
        if self._run:
            before = self._run[-1]
            if pose.time - before.time > self._config.prediction_limit or too_fast(self._config, before, pose):
                self._run.clear()
        if not self._run:
            self._leap = leap
        self._run.append(pose)

    def _acquire(self, lost: TimedPose | None, now: float) -> bool:
        """Begin a track where enough poses agree."""
        over = -math.inf if lost is None else lost.time + self._config.prediction_limit
        found = [pose for pose in self._run if pose.time > over]
        if len(found) < self._config.acquire_frames:
            return False
        if self._leap is not None:
            x, y, z = map(add, self._shift, self._leap)
            self._shift = (x, y, z)
        if lost is None:
            self._book.note(now, "object acquired")
        else:
            distance, gap = math.dist(lost.position, found[0].position), found[0].time - lost.time
            moved = f"{distance:.3f} m from where it was {gap:.2f} s ago"
            if self._leap is not None or too_fast(self._config, lost, found[0]):
                self._book.strike(MocapFault.JUMPED, now, f"object acquired {moved}")
            else:
                self._book.note(now, f"object acquired again, {moved}")
        self._track += 1
        self._filter.clear()
        for pose in self._run:
            self._filter.add(pose)
        self._run.clear()
        return True

    def _sample(self, reading: Reading, pose: TimedPose) -> PoseSample:
        self._figures.pose(self._filter.lag, reading.frame_number, pose.position)
        return measured(
            reading.time, pose.position, pose.quaternion, self._filter.velocity, self._filter.body_rates,
            reading.frame_number, self._figures.poses, self._track, self._shift, reading.arrival - reading.time,
        )  # fmt: skip


class Pipeline:
    """One object's way from datagrams to poses: the same for all cameras."""

    def __init__(self, config: MocapConfig, log: EventLog[MocapEvent]) -> None:
        self._config = config
        self.book, self._figures = FaultBook(log, config.hold), Figures()
        self.stream = StreamReader(config, self.book, self._figures)
        self._tracker = PoseTracker(config, self.book, self._figures)
        self.latest = nothing_yet()  # newest measurement; replaced as a whole

    @property
    def ready(self) -> bool:
        return self.latest.count > 0 and self.stream.monitor.near(RATE_AT_OPEN) is True

    @property
    def wrong_rate(self) -> float | None:
        """The measured rate, if it is far from the configured one [1/s]."""
        return self.stream.frame_rate if self.stream.monitor.near(RATE_AT_OPEN) is False else None

    def feed(self, datagram: bytes, sender: Sender, arrival: float, raw: float) -> None:
        reading = self.stream.read(datagram, sender, arrival, raw)
        sample = None if reading is None else self._tracker.take(reading)
        if sample is not None:
            self.latest = replace(sample, fault=self.book.holds)

    def at(self, now: float) -> PoseSample:
        return self.latest.at(now, self._config.stale_after, self._config.prediction_limit)

    def tick(self, now: float) -> None:
        self.stream.tick(now)
        for fault, limit in self._limits:
            over = now - self.latest.time > limit
            self.book.keep(fault, over, now, f"no pose for {1e3 * limit:.0f} ms" if over else "")
        self.book.tick(now)
        if self.latest.fault != self.book.holds:
            self.latest = replace(self.latest, fault=self.book.holds)

    def deadline(self, now: float) -> float:
        """When `tick` must be called next if nothing comes [s]; ∞ if there is nothing to wait for."""
        ages = [self.latest.time + limit for _, limit in self._limits]
        times = (*ages, self.stream.deadline, self.book.deadline)
        return min((time for time in times if time > now), default=math.inf)

    @property
    def _limits(self) -> tuple[tuple[MocapFault, float], ...]:
        """Ages of the newest pose that are faults; none before there is one."""
        config = self._config
        limits = (MocapFault.STALE, config.stale_after), (MocapFault.LOST, config.prediction_limit)
        return limits if self.latest.count else ()

    def statistics(self) -> MocapStatistics:
        return self._figures.statistics(self.book.counts, self.stream.frame_rate, self._config.latency)
