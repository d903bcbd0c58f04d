"""The emulated autopilot's rules alone, in a world whose time is made up."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pixhawk_rig import NO
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.brain import Brain
from doorman.rig.emulators.autopilot.control import Demand
from doorman.rig.emulators.autopilot.dialects import Dialect, ParameterStore
from doorman.rig.emulators.autopilot.estimator import FLIP, Estimate
from doorman.rig.emulators.autopilot.receiver import FLIP_QUATERNION, attitude_demand, position_demand

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
NED = mavlink.MAV_FRAME_LOCAL_NED


class Sandbox:
    """A brain and the world that it sees."""

    def __init__(self, dialect: Dialect) -> None:
        self.now = 30.0
        self.position = np.zeros(3)
        self.velocity = np.zeros(3)
        self.valid = self.on_earth = True
        self.station_age = 0.1
        self.parameters = ParameterStore(dialect.parameters, dialect.bytewise)
        if "GUID_OPTIONS" in self.parameters:
            self.parameters["GUID_OPTIONS"] = 8
        self.brain = Brain(dialect, self.parameters, self.now, self.estimate, start_up=22.0)
        self.step(0.0)

    @property
    def estimate(self) -> Estimate:
        earth = self.valid and self.on_earth
        return Estimate(self.position.copy(), self.velocity.copy(), LEVEL, NO, self.valid, earth)

    def step(self, duration: float, stream: Callable[[], None] | None = None) -> Demand:
        """Let time pass, with setpoints at 50 Hz if a stream is given."""
        end = self.now + duration
        while True:
            if stream is not None:
                stream()
            on_ground = bool(self.position[2] <= 0.01)
            demand = self.brain.update(self.now, self.estimate, on_ground, self.station_age)
            if self.now >= end - 1e-9:
                return demand
            self.now += 0.02

    def hold(self) -> None:
        self.go(2552, position=self.position + [0, 0, 0.5])

    def go(
        self,
        mask: int,
        position: np.ndarray = NO,
        velocity: np.ndarray = NO,
        acceleration: np.ndarray = NO,
        yaw: float = 0.0,
        frame: int = NED,
    ) -> None:
        """SET_POSITION_TARGET_LOCAL_NED, in the world frame."""
        fields = np.concatenate([part * FLIP for part in (position, velocity, acceleration)]).tolist()
        message = mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, mask, *fields, -yaw, 0.0)
        self.brain.aim(position_demand(message))

    def tilt(self, thrust: float = 0.6, quaternion: np.ndarray = LEVEL, mask: int = 7) -> None:
        q = (quaternion * FLIP_QUATERNION).tolist()
        message = mavlink.MAVLink_set_attitude_target_message(0, 1, 1, mask, q, 0.0, 0.0, 0.0, thrust)
        self.brain.aim(attitude_demand(self.brain.dialect, self.parameters, message))

    def request(self, name: str) -> int:
        """Ask for a mode."""
        return self.brain.request_mode(self.brain.dialect.modes[name])

    def arm(self) -> int:
        return self.brain.request_arming(True, False)

    def fly(self, height: float = 1.0) -> None:
        """In the air, obeying setpoints."""
        if self.brain.dialect.heeds_stream:
            self.step(0.6, self.hold)
        assert self.request("companion") == 0 and self.brain.is_in("companion")
        assert self.arm() == 0
        if self.brain.dialect.lifts_off_by_command:
            assert self.brain.request_take_off(height) == 0
        self.step(0.1, None if self.brain.dialect.lifts_off_by_command else self.hold)
        self.position[2] = height
        self.step(0.1, None if self.brain.dialect.lifts_off_by_command else self.hold)
        assert not self.brain.landed
