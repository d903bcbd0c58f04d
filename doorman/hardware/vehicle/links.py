"""The vehicle's links together: opened in order, closed in reverse, and one of them feeding another."""

from __future__ import annotations

import contextlib
from contextlib import ExitStack
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.background import InThread, Opened
from doorman.clocks import HELD_UP, LONGEST_WAIT, REAL_TIME, Clock
from doorman.exceptions import BackendError, DoormanError
from doorman.hardware.door import DoorSensor, DoorSource
from doorman.hardware.door.sources import objects_beside, source_of
from doorman.hardware.dynamixel import LATCHED, NoServos, ServoBus
from doorman.hardware.mocap import MocapReceiver, PoseSource
from doorman.hardware.mocap.sources.polled import PolledReceiver
from doorman.hardware.pixhawk import Authority, Autopilot, Outcome, PositionSetpoint, SampleStatus
from doorman.hardware.pixhawk.link.stream import LONGEST_BLIND_HOLD
from doorman.hardware.vehicle.config import VehicleConfig
from doorman.hardware.vehicle.doubt import Doubt
from doorman.hardware.vehicle.gripper import CLOSED, CLOSES_WITHIN, HALF_OPEN, OPENS_WITHIN, gripper_current
from doorman.hardware.vehicle.tip_force import TipForce, TipForceSource

_SLOW_TO_OPEN = OPENS_WITHIN + 0.2
"""A gripper that still holds so long after the command to let go does not open [s]."""
DRIFTS_FOR = 0.4
"""Longest wait in the air for a position that is not known: the vehicle drifts meanwhile [s]."""


@dataclass(frozen=True)
class Whereabouts:
    """Where the vehicle is, whoever says so."""

    position: Array  # P of O_B, shape (3,), world frame [m]
    velocity: Array  # Ṗ, shape (3,), world frame [m/s]
    yaw: float  # ψ [rad]
    time: float  # when that was true, by `time.monotonic` [s]
    known: bool  # whether it still holds; else it is the last that anybody said


class GripCommand(NamedTuple):
    closed: bool
    since: float  # when it was first given [s]


class VehicleLinks(Opened):
    """Autopilot, servos and, unless the autopilot's own estimate is flown on, mocap. The constructor touches no device.

    Args:
        config: Configuration of all links.
        tip_force: Reads a force sensor in a tip that pushes, if there is one.
        clock: Clock of all their waits.
        door: Measures the door, in place of what the configuration names as its sensor.
        poses: Brings the vehicle's poses, in place of the cameras that the configuration names.

    Raises:
        BackendError: if a vehicle with a gripper is given a sensor in its tip, or nothing says how the measured leaf moves.
    """

    door: DoorSensor | None = None
    """What measures the door."""

    tip_force: TipForce | None = None
    """The force sensor in the tip."""
    clock: Clock = REAL_TIME
    """Clock of the links and of their users."""

    def __init__(
        self, config: VehicleConfig, tip_force: TipForceSource | None = None, clock: Clock = REAL_TIME,
        door: DoorSource | None = None, poses: PoseSource | None = None,
    ) -> None:  # fmt: skip
        if tip_force is not None and config.gripper:
            raise BackendError("only a tip that pushes has a force sensor", field="tip_force", given="a sensor",
                               allowed="none with a gripper")  # fmt: skip
        self.config, self.clock = config, clock
        self.tip_force = None if tip_force is None else TipForce(tip_force, config.servos.stale_after)
        self.autopilot = Autopilot(config.pixhawk, clock)
        self.servos = ServoBus(config.servos, clock) if config.servos.n else NoServos(config.servos, clock)
        self.doubt = Doubt(self.autopilot, 0.0 if config.mocap is None else config.mocap.position_slack)
        """Whether the cameras' poses are believed."""
        sensor = config.door_sensor if door is None else None
        self.mocap: MocapReceiver | None = None
        if config.mocap is not None and poses is not None:
            self.mocap = PolledReceiver(config.mocap, poses, clock, self.doubt)
        elif config.mocap is not None:
            self.mocap = MocapReceiver(config.mocap, clock, objects_beside(config.mocap, sensor), self.doubt)
        if config.door_sensor is not None:
            self.door = DoorSensor(door or source_of(config.door_sensor, self.mocap, clock), config.door_sensor)
        elif door is not None:
            raise BackendError("how the leaf moves is not known", field="door_sensor", given=None,
                               allowed='vehicle_config(links={"door_sensor.source": "program"})')  # fmt: skip
        self._inhibited: str | None = None
        self._guarded_at: float | None = None
        self._relay: _Relay | None = None
        self._grip_command: GripCommand | None = None
        self._open: ExitStack | None = None

    # ------------------------------------------------------------ life

    @property
    def is_open(self) -> bool:
        """Whether the links are open."""
        return self._open is not None

    def open(self) -> None:
        """Open mocap, servos and autopilot, each with its time-out; the arm stands still, nothing flies.

        Raises:
            BackendError: if they are open already, or one of them cannot be opened; the others are closed again.
        """
        if self._open is not None:
            raise BackendError("the links are open already", allowed="stop() before another open()")
        self._inhibited = self._grip_command = None
        with ExitStack() as stack:
            if self.mocap is not None:
                stack.enter_context(self.mocap)
            stack.enter_context(self.servos)
            stack.enter_context(self.autopilot)
            if self.door is not None:
                self.door.source.open()
                stack.callback(self.door.source.stop)
            if self.mocap is not None:
                self._relay = _Relay(self.mocap, self.autopilot, self.clock)
                stack.enter_context(self._relay)
            self._open = stack.pop_all()

    def stop(self) -> None:
        """Land what still flies by our setpoints, leave the arm at rest and close everything; may be called twice."""
        links, self._open = self._open, None
        if links is not None:
            links.close()

    # ------------------------------------------------------------ what is known

    def whereabouts(self) -> Whereabouts:
        """Where the vehicle is: by the autopilot, or by the cameras while that is not heard; by who spoke last if by neither."""
        state = self.autopilot.state()
        heard = state.status is SampleStatus.FRESH
        if not heard and self.mocap is not None:
            with contextlib.suppress(BackendError):  # closed
                pose = self.mocap.read()
                newest = pose.count > 0 and not pose.time <= state.position_time and not self.doubt.holds
                if pose.usable or newest:
                    return Whereabouts(pose.position, pose.velocity, float(pose.attitude[2]), pose.time, pose.usable)
        return Whereabouts(state.position, state.velocity, float(state.attitude[2]), state.position_time, heard)

    # ------------------------------------------------------------ who may command

    @property
    def inhibited(self) -> str | None:
        """Why the mission may not command any more; None while it may. A guard that has fallen silent is a reason."""
        guarded = self._guarded_at
        if self._inhibited is None and guarded is not None and self.clock.now() - guarded > HELD_UP:
            return "the safety supervisor is silent"
        return self._inhibited

    def guard(self, time_of_sign: float | None) -> None:
        """Sign of life of whoever guards the flight.

        Args:
            time_of_sign: Time by `time.monotonic` [s]; None ends the guard.
        """
        self._guarded_at = time_of_sign

    def inhibit(self, reason: str) -> None:
        """Take the vehicle from the mission and stop the arm: every further command of the mission is an error.

        Args:
            reason: Reason in words.
        """
        self._inhibited = self._inhibited or reason
        self.rest_arm()

    def release(self) -> None:
        """Let a mission command again."""
        self._inhibited = None

    # ------------------------------------------------------------ what is commanded

    @property
    def engaged(self) -> bool:
        """Whether the autopilot obeys us."""
        return self.autopilot.status().authority is Authority.ENGAGED

    def hold(self, *, latch: bool = False) -> Outcome:
        """Stay where the vehicle is, by the autopilot's position control.

        Args:
            latch: Refuse the controller's setpoints until `autopilot.resume`.
        """
        where = self.whereabouts()
        recent = where.known or self.clock.now() - where.time < LONGEST_BLIND_HOLD
        return self.autopilot.hold(at=PositionSetpoint(where.position, where.yaw) if recent else None, latch=latch)

    def move_arm(self, rates: Array, closed: bool) -> None:
        """Command the arm's joints, and the gripper if there is one.

        Args:
            rates: Ḣ_d, shape (n,) [rad/s].
            closed: Whether the gripper holds.

        Raises:
            BackendError: if the rates are not finite, or the servos are not open.
        """
        grip = None
        if self.config.gripper:
            grip = gripper_current(float(self.servos.read().angles[-1]), closed)
            if self._grip_command is None or self._grip_command.closed != closed:
                self._grip_command = GripCommand(closed, self.clock.now())
        self.servos.command(rates, grip)

    @property
    def holding(self) -> bool:
        """Whether the gripper holds what is between its fingers; one that has not been seen for long has opened by itself.

        One that is commanded to open holds until its fingers are open for certain.
        """
        if not self.config.gripper:
            return False
        with contextlib.suppress(BackendError):  # closed
            sample = self.servos.read()
            seen = self.clock.now() - sample.times[-1] < OPENS_WITHIN
            opens = self._grip_command is not None and not self._grip_command.closed
            return bool(seen and sample.angles[-1] > (HALF_OPEN if opens else CLOSED))
        return False

    @property
    def gripped(self) -> bool:
        """Whether the gripper is commanded to close, and holds."""
        return self._grip_command is not None and self._grip_command.closed and self.holding

    @property
    def surely_holding(self) -> bool:
        """Whether the fingers are closed, whatever the command; half open ones hold nothing that pulls."""
        return self.holding and bool(self.servos.read().angles[-1] > CLOSED)

    @property
    def grip_failed(self) -> bool:
        """Whether the gripper does not do what was commanded long enough ago, or its servo has failed while it holds."""
        if self._grip_command is None:
            return False
        closed, since = self._grip_command
        if not closed:
            return self.holding and self.clock.now() - since > _SLOW_TO_OPEN
        if not self.holding:
            return self.clock.now() - since > CLOSES_WITHIN
        with contextlib.suppress(BackendError):  # closed
            return bool(self.servos.read().faults[-1] & LATCHED)
        return False

    def rest_arm(self) -> None:
        """Stop the arm; the gripper stays as it is."""
        with contextlib.suppress(BackendError):  # closed, or unplugged: then the servos' watchdogs stop it
            self.servos.command(np.zeros(self.config.n_arm))

    def let_go(self) -> None:
        """Stop the arm, and open the gripper if there is one; to be called again and again until it is open."""
        with contextlib.suppress(BackendError):
            self.move_arm(np.zeros(self.config.n_arm), closed=False)


class _Relay(InThread):
    """Thread that hands every fresh pose on to the autopilot's estimator, at the pace of the cameras."""

    def __init__(self, mocap: MocapReceiver, autopilot: Autopilot, clock: Clock) -> None:
        super().__init__("pose relay", clock)
        self._mocap, self._autopilot = mocap, autopilot

    def _run(self) -> None:
        sample = self._mocap.read()
        while not self._stopping.is_set():
            try:
                sample = self._mocap.wait(sample, LONGEST_WAIT)
                if sample.fresh:
                    self._autopilot.mocap(sample.time, sample.position, sample.quaternion)
            except DoormanError:  # no pose for now: whoever reads the sample or its age sees it
                self._stopping.wait(0.01)
