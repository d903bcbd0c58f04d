"""The real vehicle as a backend: what the mission loop flies instead of a simulator, tick by tick."""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass, replace

import numpy as np

from doorman.checks import number, vector
from doorman.clocks import HELD_UP, REAL_TIME, Clock
from doorman.exceptions import BackendError, DimensionError
from doorman.gravity import weight_of
from doorman.hardware.interface import Backend, Command, Measurement
from doorman.hardware.mocap import PoseSample
from doorman.hardware.pixhawk import AttitudeSetpoint, PositionSetpoint
from doorman.hardware.vehicle.links import VehicleLinks
from doorman.hardware.vehicle.measurement import compose
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model

_KEPT = 200_000


@dataclass(frozen=True)
class TickStatistics:
    ticks: int
    missed: int  # ticks that were left out since the one before took too long
    median: float  # of the periods [s]
    p99_9: float  # 99.9th percentile of |period − nominal| [s]
    longest: float  # longest period [s]


class Ticker:
    """Waits for the next tick; a tick that has passed already is left out, not made up for."""

    def __init__(self, period: float, clock: Clock = REAL_TIME) -> None:
        self.period, self._clock = period, clock
        self._next: float | None = None
        self._last = 0.0
        self.missed = 0  # ticks that were left out
        self.periods: list[float] = []  # between ticks, the first of them [s]

    def wait(self) -> float:
        now = self._clock.now()
        if self._next is None:
            self._next = self._last = now
            return now
        self._next += self.period
        if now > self._next:
            late = int((now - self._next) / self.period)
            self.missed += late
            self._next += late * self.period
        self._clock.reach(self._next)
        now = self._clock.now()
        if now > self._last and len(self.periods) < _KEPT:
            self.periods.append(now - self._last)
        self._last = now
        return now

    def statistics(self) -> TickStatistics:
        periods = np.array(self.periods or [self.period])
        return TickStatistics(
            ticks=len(self.periods) + 1,
            missed=self.missed,
            median=float(np.median(periods)),
            p99_9=float(np.percentile(np.abs(periods - self.period), 99.9)),
            longest=float(periods.max()),
        )


class VehicleBackend(Backend):
    """Autopilot, servos and mocap behind the interface that the simulator has, too.

    It neither arms nor takes off: the vehicle is in the air already, and engaged, when commands are to have an effect. Links
    that are open already stay open after `stop`; the vehicle then holds its place.

    Args:
        model: Model of the scenario.
        links: The vehicle's links.
    """

    real_time = True
    comes_back = True
    pose_delay: float = 0.0
    """Delay of poses beyond their stamps, as measured in flight [s]."""

    def __init__(self, model: Model, links: VehicleLinks) -> None:
        if links.config.n_arm != model.n_arm:
            raise BackendError("the servos do not match the arm", field="servos.ids", given=links.config.n_arm,
                               allowed=f"one for each of {model.n_arm} joints")  # fmt: skip
        self.model = model
        self.links = links
        self._attitude_setpoints = links.config.pixhawk.setpoints == "attitude"
        self._own_links = self._is_open = False
        self.epoch = math.nan
        """When the backend's time was zero, by `time.monotonic`; kept after `stop` [s]."""
        self._ticker = Ticker(1.0 / links.config.rate, links.clock)
        self._measured: Measurement | None = None
        self.commanded_at = -math.inf
        """When a command was sent last, by `time.monotonic` [s]."""
        self.began_at = -math.inf
        """When a mission measured first, by `time.monotonic` [s]."""
        self.thrust, self.attitude = math.nan, np.full(3, math.nan)
        """Thrust that was commanded last [N]."""

    @property
    def commanding(self) -> bool:
        """Whether a mission flies it: it has measured, and not stopped since."""
        return self._measured is not None

    @property
    def missed_ticks(self) -> int:
        """Ticks that were left out since it was opened."""
        return self._ticker.missed

    @property
    def ticks(self) -> TickStatistics:
        """Statistics of the controller's ticks."""
        return self._ticker.statistics()

    @property
    def feedback_lag(self) -> float:
        """Lag of the feedback of the autopilot that answers [s]; see `Backend`."""
        return self.links.autopilot.status().feedback_lag

    def open(self) -> None:
        """Open the links, unless they are, and begin to count time.

        Raises:
            BackendError: if it is open already, or a link cannot be opened.
        """
        if self._is_open:
            raise BackendError("the vehicle is open already", allowed="stop() before another open()")
        self._own_links = not self.links.is_open
        if self._own_links:
            self.links.open()
        self._ticker = Ticker(1.0 / self.links.config.rate, self.links.clock)
        self._measured, self.thrust = None, math.nan
        self.attitude = np.full(3, math.nan)
        self._is_open, self.epoch = True, self.links.clock.now()

    def read(self) -> Measurement:
        """Wait for the next tick and say what the links know then.

        Returns:
            The measurement, everything carried on to the time of the tick.

        Raises:
            BackendError: if it is not open, the mission may not command any more, or a link has nothing usable.
        """
        deadline = self.links.clock.now() + (HELD_UP if self._measured is None else 0.0)
        while True:
            now = self._ticker.wait()
            self._require_permission()
            try:
                measured = self._compose(now)
            except BackendError:
                if now >= deadline:
                    raise
                continue
            if self._measured is None:
                self.began_at = now
            self._measured = measured
            return measured

    def command(self, command: Command) -> None:
        """Send thrust and attitude to the autopilot and joint rates to the servos.

        Args:
            command: What to do until the next one.

        Raises:
            BackendError: if it is not open or the command is not finite; if the mission may not command any more, or the
                autopilot does not obey us.
        """
        self._require_permission()
        try:
            thrust, side = number(command.thrust, "command.thrust"), vector(command.side_force, 2, "command.side_force")
            attitude = vector(command.attitude, 3, "command.attitude")
            arm_rates = vector(command.arm_rates, self.model.n_arm, "command.arm_rates")
        except DimensionError as error:
            raise BackendError(f"not a command: {error}", field="command") from error
        if side.any() and not (self._attitude_setpoints and self.links.config.pixhawk.rotors):
            raise BackendError("setpoints carry no force to the side", field="command.side_force", given=command.side_force,
                               allowed="(0, 0), or attitude setpoints of a fully actuated vehicle")  # fmt: skip
        self.links.move_arm(arm_rates, command.grip)
        if not self.links.autopilot.setpoint(self._setpoint(thrust, attitude, command.side_force)):
            authority = self.links.autopilot.status().authority
            raise BackendError("doorman does not control the autopilot", field="pixhawk", given=authority.value,
                               allowed="engaged, and not held")  # fmt: skip
        self.thrust, self.commanded_at = thrust, self.links.clock.now()
        self.attitude = attitude

    def stop(self) -> None:
        """Stop the arm, hold the place, and close the links if they were opened here; may be called twice."""
        if not self._is_open:
            return
        self._is_open, self._measured = False, None
        self.links.rest_arm()
        with contextlib.suppress(BackendError):
            if self.links.inhibited is None and self.links.engaged:
                self.links.hold()
        if self._own_links:
            self.links.stop()

    def _setpoint(
        self, thrust: float, attitude: np.ndarray, side_force: tuple[float, float]
    ) -> AttitudeSetpoint | PositionSetpoint:
        """The command as attitude and thrust, or as the acceleration that these make."""
        # The latter stands at the measured position and velocity, so that the autopilot's own loops add nothing to it.
        if self._attitude_setpoints:
            return AttitudeSetpoint(thrust, attitude, side_force)
        measured = self._measured
        if measured is None:
            raise BackendError("position setpoints start from a measurement", allowed="read() before command()")
        acceleration = thrust / self.model.vehicle.mass * rotation_body_to_world(attitude)[:, 2]
        acceleration[2] -= weight_of(1.0)
        return PositionSetpoint(measured.position, float(attitude[2]), measured.velocity, acceleration)

    def _compose(self, now: float) -> Measurement:
        links, leaf, frame = self.links, None, None
        state, pose = links.autopilot.state(), self._newest_pose()
        if links.door is not None:
            seen, at = (state, state.position_time) if pose is None else (pose, pose.time)
            links.door.note_pose(at, seen.position, seen.attitude)
            leaf, frame = links.door.read(now, self.epoch)
        return compose(
            now, self.epoch, state, links.servos.read(), pose, links.config,
            None if links.tip_force is None else links.tip_force.read(now), leaf, frame,
        )  # fmt: skip

    def _newest_pose(self) -> PoseSample | None:
        """The newest pose that was measured, as long as a prediction from it would be usable."""
        if self.links.mocap is None:
            return None
        pose = self.links.mocap.read()
        if not pose.usable:
            raise BackendError(f"the pose is {pose.quality.value}", field="mocap", given=f"age {pose.age:.3f} s",
                               allowed="measured, or predicted for a short while")  # fmt: skip
        pose = pose.origin or pose
        return replace(pose, time=min(pose.time - self.pose_delay, self.links.clock.now()))

    def _require_permission(self) -> None:
        if not self._is_open:
            raise BackendError("the vehicle is not open", allowed="open() before read() and command()")
        if (reason := self.links.inhibited) is not None:
            raise BackendError(f"the supervisor took the vehicle from the mission: {reason}", field="safety")
