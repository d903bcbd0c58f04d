"""Sensors: the truth as motion capture, servos and gyroscope tell it: noisy, late, with gaps; the door's angle is not seen.

Motion capture samples position, velocity and attitude at its rate, loses the samples of a gap, and delivers the others after
its latency and jitter; meanwhile the last pose holds. It may take markers for others.

The arm's angles and rates come by another cable: as late, without gaps or
jitter, and with the servos' play. Body rates are the gyroscope's, and a force sensor's readings the tip's, of the present moment.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple, TypeVar

import numpy as np

from doorman.arrays import Array, sealed
from doorman.scenario import NoiseSection, SensorsSection
from doorman.signals import Measurement
from doorman.simulation.chance import Dropouts
from doorman.simulation.delay_line import ROUNDED
from doorman.simulation.reality.seen_frame import Swaps, seen_frame
from doorman.simulation.truth import Truth

_DROPOUTS = 1
"""Stream of random numbers of a seed for gaps; the noise has the seed's own."""
_JITTER = 4
"""The stream that makes the jitter."""
_TIP_FORCE = 6
"""The stream that makes the noise of the tip's force sensor."""


class _Pose(NamedTuple):
    """What motion capture sees at one time."""

    time: float
    position: Array
    velocity: Array
    attitude: Array
    delay: float = 0.0  # by which it is later than the latency [s]


class _Arm(NamedTuple):
    """What the servos say at one time."""

    time: float
    angles: Array
    rates: Array
    delay: float = 0.0


_Sample = TypeVar("_Sample", _Pose, _Arm)


class Sensors:
    """Measurements of one flight, with independent noise at every tick."""

    def __init__(
        self, noise: NoiseSection, seed: int, delivery: SensorsSection | None = None, backlash: float = 0.0
    ) -> None:
        self._noise, self._deviations = noise, np.empty(0)
        self._generator = np.random.default_rng(seed)
        self._delivery = delivery or SensorsSection()
        self._dropouts = Dropouts(self._delivery.dropout_rate, self._delivery.dropout_duration, [seed, _DROPOUTS])
        self._frame, self._swaps = seen_frame(self._delivery, seed), Swaps(self._delivery, seed)
        self._jitter = np.random.default_rng([seed, _JITTER])
        self._tip_noise = np.random.default_rng([seed, _TIP_FORCE])
        self._backlash, self._servo_angles = backlash, np.empty(0)
        self._next_sample = 0.0
        self._poses: deque[_Pose] = deque()
        self._arms: deque[_Arm] = deque()

    def measure(self, truth: Truth) -> Measurement:
        """What the sensors say at one time."""
        n, time = len(truth.arm_angles), truth.time
        if not self._deviations.size:
            self._deviations = self._spread(n)
        noise = self._deviations * self._generator.standard_normal(12 + 2 * n)
        arm_angles = self._behind_play(truth.arm_angles) if self._backlash else truth.arm_angles
        position, velocity, attitude = truth.position, truth.velocity, truth.attitude
        sampled = self._samples(time)
        if sampled and self._frame is not None:
            self._frame.advance(time)
            position, velocity = self._frame.position(position), self._frame.velocity(velocity)
            attitude = self._frame.attitude(attitude)
        if sampled and self._delivery.swap_rate > 0.0:
            off = self._swaps.off(time)
            position, attitude = position + off[:3], attitude + off[3:]
        true = np.concatenate((position, velocity, attitude, truth.body_rates, arm_angles, truth.arm_rates))
        seen = sealed(true + noise)
        if sampled:
            self._keep(self._poses, self._pose(time, seen, velocity))
        self._keep(self._arms, _Arm(time, seen[12 : 12 + n], seen[12 + n :]))
        pose, arm = self._delivered(self._poses, time), self._delivered(self._arms, time)
        tip_force = None
        if self._delivery.tip_force:
            error = self._noise.tip_force * float(self._tip_noise.standard_normal())
            tip_force = truth.tip_normal_force + error
        return Measurement(
            time=time,
            position=pose.position,
            velocity=pose.velocity,
            attitude=pose.attitude,
            body_rates=seen[9:12],
            arm_angles=arm.angles,
            arm_rates=arm.rates,
            pose_time=pose.time,
            arm_time=arm.time,
            tip_force=tip_force,
        )

    def _spread(self, n: int) -> Array:
        """Deviations of everything that is measured, shape (12 + 2 n,)."""
        noise = self._noise
        of_vehicle = np.repeat([noise.position, noise.velocity, noise.attitude, noise.body_rates], 3)
        return np.concatenate((of_vehicle, np.repeat([noise.arm_angles, noise.arm_rates], n)))

    def _samples(self, time: float) -> bool:
        """Whether it is time for a sample of the pose, and it is not lost."""
        rate = self._delivery.rate
        if rate is not None:
            if time < self._next_sample - ROUNDED:
                return False
            while self._next_sample <= time + ROUNDED:
                self._next_sample += 1.0 / rate
        return not self._dropouts.lost(time)

    def _pose(self, time: float, seen: Array, true_velocity: Array) -> _Pose:
        delay = self._delivery.jitter * float(self._jitter.uniform()) if self._delivery.jitter > 0.0 else 0.0
        position, velocity = seen[0:3], seen[3:6]
        if self._delivery.velocity != "measured":
            velocity = true_velocity.copy()  # at rest
            if self._poses:
                last = self._poses[-1]
                velocity = (position - last.position) / (time - last.time)
        return _Pose(time, position, sealed(velocity), seen[6:9], delay)

    def _behind_play(self, angles: Array) -> Array:
        """What the servos say: they follow the joints no closer than their play, shape (n,) [rad]."""
        before = self._servo_angles if self._servo_angles.size else angles
        free = 0.5 * self._backlash
        self._servo_angles = np.clip(before, angles - free, angles + free)
        return self._servo_angles

    def _keep(self, samples: deque[_Sample], sample: _Sample) -> None:
        """Append a sample; before the first there was one that has just arrived, as all was at rest."""
        if not samples and self._delivery.latency > 0.0:
            samples.append(sample._replace(time=sample.time - self._delivery.latency))
        samples.append(sample)

    def _delivered(self, samples: deque[_Sample], now: float) -> _Sample:
        """The newest sample that has arrived."""
        latency = self._delivery.latency
        while len(samples) > 1 and samples[1].time + samples[1].delay + latency <= now + ROUNDED:
            samples.popleft()
        return samples[0]
