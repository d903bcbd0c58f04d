"""Sensors: the truth with white noise on it; the door's angle is not among what they see."""

from __future__ import annotations

import numpy as np

from doorman.hardware.interface import Measurement
from doorman.kinematics.urdf import frozen
from doorman.scenario import NoiseSection
from doorman.simulation.truth import Truth


class Sensors:
    """Pose, velocities and joint angles, with independent noise at every tick.

    Args:
        noise: Standard deviations.
        seed: Of the noise; the same seed gives the same noise to the bit.
    """

    def __init__(self, noise: NoiseSection, seed: int) -> None:
        self._noise = noise
        self._generator = np.random.default_rng(seed)

    def measure(self, truth: Truth) -> Measurement:
        """What the sensors say at one time.

        Args:
            truth: The plant at that time.

        Returns:
            The measurement.
        """
        n = len(truth.arm_angles)
        draws = self._generator.standard_normal(12 + 2 * n)
        noise = self._noise
        return Measurement(
            time=truth.time,
            position=frozen(truth.position + noise.position * draws[0:3]),
            velocity=frozen(truth.velocity + noise.velocity * draws[3:6]),
            attitude=frozen(truth.attitude + noise.attitude * draws[6:9]),
            body_rates=frozen(truth.body_rates + noise.body_rates * draws[9:12]),
            arm_angles=frozen(truth.arm_angles + noise.arm_angles * draws[12 : 12 + n]),
            arm_rates=frozen(truth.arm_rates + noise.arm_rates * draws[12 + n :]),
        )
