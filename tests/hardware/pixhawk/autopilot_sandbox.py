"""The emulated autopilot's rules alone, in a world whose time is made up."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pixhawk_rig import NO
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot import px4
from doorman.rig.emulators.autopilot.brain import AttitudeTarget, Brain, PositionTarget, Surroundings
from doorman.rig.emulators.autopilot.control import Demand
from doorman.rig.emulators.autopilot.estimator import Estimate

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
NED = mavlink.MAV_FRAME_LOCAL_NED


class Sandbox:
    """A brain and the world that it sees."""

    def __init__(self, brain: Brain) -> None:
        self.brain = brain
        self.now = 30.0
        self.position = np.array([0.0, 0.0, 0.0])
        self.velocity = np.zeros(3)
        self.attitude = LEVEL
        self.valid = self.on_earth = True
        self.station_age = 0.1
        self.step(0.0)

    def step(self, duration: float, stream: Callable[[], None] | None = None) -> Demand:
        """Let time pass, with setpoints at 50 Hz if a stream is given."""
        end = self.now + duration
        while True:
            if stream is not None:
                stream()
            on_ground = bool(self.position[2] <= 0.01)
            estimate = Estimate(
                self.position.copy(), self.velocity.copy(), self.attitude, NO, self.valid, self.valid and self.on_earth
            )
            demand = self.brain.update(Surroundings(self.now, estimate, on_ground, self.station_age))
            if self.now >= end - 1e-9:
                return demand
            self.now += 0.02

    def hold(self) -> None:
        self.brain.position_target(PositionTarget(2552, NED, self.position + [0, 0, 0.5], NO, NO, 0.0))

    def tilt(self, thrust: float = 0.6, quaternion: np.ndarray = LEVEL, mask: int = 7) -> None:
        self.brain.attitude_target(AttitudeTarget(mask, quaternion, thrust))


def offboard(sandbox: Sandbox) -> None:
    """PX4 obeys its stream."""
    sandbox.step(0.6, sandbox.hold)
    assert sandbox.brain.request_mode((1.0, 6.0, 0.0)) == 0
    assert sandbox.brain.mode == px4.OFFBOARD
