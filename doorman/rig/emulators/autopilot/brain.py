"""What PX4 and ArduPilot have in common: mode, arming, demand of the moment, landing and what they say about it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.control import Demand, Task
from doorman.rig.emulators.autopilot.estimator import Estimate
from doorman.rig.emulators.autopilot.parameters import ParameterStore
from doorman.rig.emulators.autopilot.plant import Array, yaw_of
from doorman.rig.emulators.autopilot.way_home import Home, Return

ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED = 0, 1, 2, 3, 4
"""MAV_RESULT."""
_STANDING = 0.1
"""A landing that sinks more slowly has stopped [m/s],"""
_KILLED = 5.0
"""After this time a vehicle whose motors a switch has stopped is disarmed [s]."""
_STUCK = 1.0
"""after this time [s]."""


@dataclass(frozen=True)
class AttitudeTarget:
    """A decoded SET_ATTITUDE_TARGET, world frame."""

    mask: int
    quaternion: Array
    thrust: float
    thrust_body: Array = field(default_factory=lambda: np.zeros(3))
    """Body axes, z up."""


@dataclass(frozen=True)
class PositionTarget:
    """A decoded SET_POSITION_TARGET_LOCAL_NED, world frame."""

    mask: int
    frame: int
    position: Array
    velocity: Array
    acceleration: Array
    yaw: float

    @property
    def has_position(self) -> bool:
        """Whether the position counts."""
        return not self.mask & 7

    @property
    def has_velocity(self) -> bool:
        """Whether the velocity counts."""
        return not self.mask & 0x38

    @property
    def has_acceleration(self) -> bool:
        """Whether the acceleration counts."""
        return not self.mask & 0x1C0


@dataclass
class Surroundings:
    """What a brain knows at an instant of its own clock."""

    now: float
    estimate: Estimate
    on_ground: bool
    ground_station_age: float
    """Since the last heartbeat of a ground station [s]; infinity before the first."""


@dataclass
class Refusal:
    """How the next requests to arm are refused."""

    active: bool = False
    text: str = ""
    """Said by STATUSTEXT; empty for a silent refusal, as PX4 gives at times."""


class Brain(ABC):
    """Modes and rules of one autopilot.

    Args:
        parameters: Its parameters.
    """

    vendor: int
    """MAV_AUTOPILOT."""
    stick_mode: int
    """The mode in which the pilot's sticks are velocities, and a vehicle whose sticks are let go of stays where it is."""
    heeds_force = False
    """Whether a forced request arms it in spite of its checks."""

    def __init__(self, parameters: ParameterStore) -> None:
        self.parameters = parameters
        self.mode = 0
        self.armed = False
        self.failsafe = False
        self.landed = True
        self.refusal = Refusal()
        self.texts: list[tuple[int, str]] = []
        """Severity and words, waiting to be sent."""
        self.demand = Demand(Task.IDLE)
        self.home = Home(np.zeros(3), 0.0)
        self.sticks = np.zeros(3)
        """Velocity that the pilot asks for, shape (3,), world frame [m/s]."""
        self.around: Surroundings | None = None
        self._hold: Demand | None = None
        self._return: Return | None = None
        self._grounded_since: float | None = None
        self._stuck_since: float | None = None
        self._armed_at = 0.0
        self._killed_at: float | None = None

    # ------------------------------------------------------------ requests

    @abstractmethod
    def request_mode(self, parameters: Sequence[float]) -> int:
        """DO_SET_MODE with its first three parameters; returns a MAV_RESULT."""

    @abstractmethod
    def request_take_off(self, height: float) -> int:
        """NAV_TAKEOFF to a height [m], of PX4 in its local frame, of ArduPilot above home; returns a MAV_RESULT."""

    @abstractmethod
    def request_land(self) -> int:
        """NAV_LAND; returns a MAV_RESULT."""

    @abstractmethod
    def request_return(self) -> int:
        """NAV_RETURN_TO_LAUNCH; returns a MAV_RESULT."""

    @abstractmethod
    def attitude_target(self, target: AttitudeTarget) -> None:
        """SET_ATTITUDE_TARGET."""

    @abstractmethod
    def position_target(self, target: PositionTarget) -> None:
        """SET_POSITION_TARGET_LOCAL_NED."""

    @abstractmethod
    def pilot_mode(self, name: str) -> None:
        """The pilot turns the mode switch of the radio."""

    @abstractmethod
    def _arming_refused(self, forced: bool) -> tuple[int, str] | None:
        """Result and words of a refusal, None if it may arm; forced, of the checks that nobody skips."""

    @abstractmethod
    def _decide(self, around: Surroundings) -> Demand:
        """Failsafes, and what to do now."""

    @abstractmethod
    def _begin_return(self, around: Surroundings) -> Return:
        """The way home from here, as the parameters have it."""

    def request_arming(self, arm: bool, forced: bool) -> int:
        """COMPONENT_ARM_DISARM; returns a MAV_RESULT."""
        assert self.around is not None
        if arm == self.armed:
            return ACCEPTED
        if not arm:
            if not self.landed and not forced:
                return self.refused_result
            self._disarm()
            return ACCEPTED
        refused = self.check_arming(forced and self.heeds_force)
        if refused is not None:
            return refused
        self.armed, self._armed_at = True, self.around.now
        self.home = Home.of(self.around.estimate)
        return ACCEPTED

    def check_arming(self, forced: bool = False) -> int | None:
        """MAV_RESULT of a request to arm that would be refused now, and its words by STATUSTEXT; None if it may arm."""
        refuses = self.refusal.active and not forced
        refusal = (self.refused_result, self.refusal.text) if refuses else self._arming_refused(forced)
        if refusal is None:
            return None
        if refusal[1]:
            self.say(mavlink.MAV_SEVERITY_CRITICAL, refusal[1])
        return refusal[0]

    @property
    @abstractmethod
    def refused_result(self) -> int:
        """MAV_RESULT of a refused arming."""

    # ------------------------------------------------------------ every step

    def update(self, around: Surroundings) -> Demand:
        """Think once.

        Args:
            around: What is known now.

        Returns:
            What the vehicle is to do.
        """
        self.around = around
        self._watch_ground(around)
        demand = self._decide(around)
        if self._killed_at is not None and around.now - self._killed_at > _KILLED:
            self._disarm()
        self.demand = demand if self.armed and not self.killed else Demand(Task.IDLE)
        return self.demand

    @property
    def killed(self) -> bool:
        """Whether a switch of the radio has stopped the motors; armed in the same mode for a while."""
        return self._killed_at is not None

    def kill(self, stop: bool) -> None:
        """The pilot's kill switch.

        Args:
            stop: Whether the motors are to stop; else those of a vehicle that is still armed run again.
        """
        assert self.around is not None
        self._killed_at = self.around.now if stop and self.armed else None

    def say(self, severity: int, text: str) -> None:
        """Queue a STATUSTEXT."""
        self.texts.append((severity, text))

    def hold_here(self, around: Surroundings) -> Demand:
        """Stay at the place where this was first asked for, or follow the pilot's sticks."""
        if self.mode == self.stick_mode and self.sticks.any():
            self._hold = None
            return Demand(Task.VELOCITY, velocity=self.sticks)
        if self._hold is None:
            self._hold = Demand(
                Task.POSITION, position=around.estimate.position.copy(), yaw=yaw_of(around.estimate.quaternion)
            )
        return self._hold

    def return_home(self, around: Surroundings) -> Demand:
        """Fly home and land there."""
        if self._return is None:
            self._return = self._begin_return(around)
        return self._return.demand(around.estimate, around.now)

    def _enter(self, mode: int) -> None:
        if mode != self.mode:
            self._hold = self._return = None
        self.mode = mode

    def _disarm(self) -> None:
        self.armed = False
        self._grounded_since = self._killed_at = None

    def _watch_ground(self, around: Surroundings) -> None:
        """Landed while on the ground and not about to leave it; long enough while landing, it disarms."""
        idle = self.demand.task in (Task.IDLE, Task.LAND)
        on_ground = (around.on_ground or self._stuck(around)) and (not self.armed or self._feels_ground(around))
        self.landed = on_ground and (idle or not self.armed or self.landed)
        if not (self.armed and self.landed and self.demand.task is Task.LAND):
            self._grounded_since = None
            return
        self._grounded_since = around.now if self._grounded_since is None else self._grounded_since
        if around.now - self._grounded_since > self.disarm_delay:
            self._disarm()

    def _feels_ground(self, around: Surroundings) -> bool:
        """Whether it can find out that it has landed."""
        return True

    def _stuck(self, around: Surroundings) -> bool:
        """Whether a landing has stopped on something, as land detectors find it: told to descend, it does not."""
        sinks = abs(float(around.estimate.velocity[2])) > _STANDING
        if not self.armed or self.demand.task is not Task.LAND or sinks:
            self._stuck_since = None
            return False
        self._stuck_since = around.now if self._stuck_since is None else self._stuck_since
        return around.now - self._stuck_since > _STUCK

    @property
    def taking_off(self) -> bool:
        """Whether it lifts off by its own controller."""
        return False

    @property
    @abstractmethod
    def disarm_delay(self) -> float:
        """Between touching the ground in a landing and disarming [s]."""
