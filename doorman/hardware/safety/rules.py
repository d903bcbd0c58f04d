"""What the supervisor sees, what can go wrong in flight, how long it may last, and what is done: the fault table as data."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum, IntEnum

import numpy as np

from doorman.arrays import Array
from doorman.hardware.dynamixel import LATCHED, BusState, ServoFault
from doorman.hardware.mocap import PoseQuality
from doorman.hardware.pixhawk import Authority, EventKind
from doorman.scenario import SafetySection


@dataclass(frozen=True)
class Observation:
    """State of vehicle, links and mission; NaN where something is unknown, which no bound takes for safe or unsafe."""

    now: float
    """By `time.monotonic` [s]."""
    armed: bool = True
    commanding: bool = True
    """Whether the mission is flying: only then must commands come."""
    authority: Authority = Authority.ENGAGED
    conditions: frozenset[EventKind] = frozenset()
    """Conditions of the autopilot's link."""
    position: Array = field(default_factory=lambda: np.full(3, math.nan))
    """Position of O_B, shape (3,), world frame [m]."""
    speed: float = math.nan
    """[m/s]."""
    tilt: float = math.nan
    """[rad]."""
    thrust_share: float = math.nan
    """Commanded thrust over the largest."""
    force: float = math.nan
    """Estimated force of the surroundings on the vehicle [N]."""
    lift: float = math.nan
    """Its share upwards, over the weight."""
    pose: PoseQuality | None = None
    """None where the autopilot's own estimate is flown on."""
    pose_jumped: bool = False
    """Whether there is no usable pose because the cameras saw the vehicle jump."""
    pose_age: float = math.nan
    """Age of a pose as the next one comes, over the oldest that the controller's gains bear."""
    misfit: float = math.nan
    """Misfit of pose, arm and door while the gripper holds, in standard deviations."""
    divergence: float = math.nan
    """Between the cameras' and the autopilot's position [m]."""
    disobedience: float = math.nan
    """Angle by which the autopilot steers elsewhere than commanded, or is on its way to, with the door in the gripper [rad]."""
    grips_unheard: bool = False
    """Whether the gripper holds the door while only the cameras see the vehicle: the autopilot may not hear us either."""
    battery: float = math.nan
    """Share of the charge."""
    servo_fault: ServoFault = ServoFault.NONE
    grip_failed: bool = False
    """Whether the gripper does not hold, or let go, though it should, or its servo has failed while it holds."""
    servo_state: BusState = BusState.FOLLOWING
    command_age: float = 0.0
    """Since the mission's last command [s]."""
    missed_ticks: float = 0.0
    """Share of the controller's ticks that were missed in the last second."""


class Action(IntEnum):
    """What is done; a greater one replaces a smaller one, never the other way round."""

    ABORT = 1
    """The mission is asked to leave the door, to retreat and to end; its controller still flies."""
    RETREAT = 2
    """The mission loses the vehicle. The gripper opens, the autopilot flies back to the hover point and lands."""
    LAND = 3
    """The arm stops, the autopilot lands where it is."""
    RELEASE = 4
    """Nothing is commanded any more: the pilot or the autopilot's own failsafe flies."""


class Fault(Enum):
    """What the supervisor recognises."""

    PILOT = "the pilot or the autopilot's failsafe has taken over"
    LINK = "the autopilot is silent"
    HEARTBEAT = "the autopilot sends no heartbeats"
    STATE = "the autopilot's state is too old"
    TELEMETRY = "the autopilot is silent, but the cameras see the vehicle"
    TELEMETRY_GRIPPING = "the autopilot is silent while the gripper holds the door"
    POSE = "the cameras have lost the vehicle"
    POSE_JUMPED = "the cameras see the vehicle jump"
    POSE_LATE = "the poses come too late"
    INCONSISTENT = "pose, arm and door do not fit together: cameras or joint angles have drifted, or the gripper slips"
    DIVERGENCE = "cameras and autopilot disagree on the position"
    DISOBEDIENCE = "the autopilot does not follow commands while the gripper holds the door"
    TILT = "the vehicle tilts too far"
    FENCE = "the vehicle is outside the fence"
    SPEED = "too fast"
    FORCE = "too much force on the vehicle"
    THRUST = "thrust is saturated"
    CONTROLLER = "the controller is silent"
    DEADLINES = "the controller misses its ticks"
    BATTERY_LOW = "the battery is low"
    BATTERY_CRITICAL = "the battery is nearly empty"
    BATTERY_SILENT = "the autopilot no longer reports the battery's charge"
    SERVOS_DISCONNECTED = "the servos' device is gone"
    GRIPPER = "the gripper does not hold or let go of the door, or its servo has failed"
    SERVOS_FAILED = "a servo has failed"
    SERVOS_JUMPED = "a servo's angle has jumped"
    SERVOS_STOPPED = "the arm does not follow"
    OPERATOR_ABORT = "the operator has given the mission up"
    OPERATOR_LAND = "the operator wants to land"
    TERMINATED = "the program was asked to end"
    SESSION = "the program that would fly the vehicle back has failed"
    SESSION_SILENT = "the program that flies the vehicle is silent"
    MISSION_STUCK = "the mission does not end"


Condition = Callable[[Observation, SafetySection], bool]


@dataclass(frozen=True)
class Rule:
    """One row of the table."""

    fault: Fault
    patience: float
    """Time for which it must hold [s]."""
    action: Action
    words: str
    """When it holds, as the documentation's table says it."""
    holds: Condition
    """Whether it holds now."""
    limits: tuple[str, ...] = ()
    """Keys of `[safety]` that bound it."""


def _conditions(*kinds: EventKind) -> Condition:
    return lambda seen, _: not seen.conditions.isdisjoint(kinds)


def _above(figure: str, limit: str, in_mission: bool = False) -> Condition:
    """Whether a figure exceeds a limit; with `in_mission`, only while the mission commands."""
    return lambda seen, limits: (seen.commanding or not in_mission) and getattr(seen, figure) > getattr(limits, limit)


def _outside(seen: Observation, limits: SafetySection) -> bool:
    low, high = limits.fence
    return bool((seen.position < low).any() or (seen.position > high).any())


def _seen_only(seen: Observation, _: SafetySection) -> bool:
    """Whether only the cameras say where the vehicle is: it can be flown by them."""
    return seen.pose is not None and seen.pose.usable and EventKind.STATE_STALE in seen.conditions


def _unseen(kind: EventKind) -> Condition:
    return lambda seen, limits: kind in seen.conditions and not _seen_only(seen, limits)


def _servos_stopped(seen: Observation, _: SafetySection) -> bool:
    return seen.commanding and seen.servo_state is BusState.HOLDING and not seen.servo_fault & ServoFault.COMMAND_STALE


RULES: tuple[Rule, ...] = (
    Rule(Fault.PILOT, 0.0, Action.RELEASE, "authority is LOST", lambda seen, _: seen.authority is Authority.LOST),
    Rule(Fault.LINK, 10.0, Action.RELEASE, "LINK_LOST or DEVICE_LOST", _conditions(EventKind.LINK_LOST, EventKind.DEVICE_LOST)),
    Rule(Fault.TILT, 0.05, Action.LAND, "tilt above", _above("tilt", "tilt"), ("tilt",)),
    Rule(Fault.DIVERGENCE, 0.3, Action.RETREAT, "distance of the cameras' and the autopilot's position above",
         _above("divergence", "divergence"), ("divergence",)),
    Rule(Fault.DISOBEDIENCE, 0.2, Action.RETREAT, "in a mission, angle between commanded and steered attitude above",
         _above("disobedience", "disobedience", in_mission=True), ("disobedience",)),
    Rule(Fault.STATE, 0.3, Action.RETREAT, "STATE_STALE, and no usable pose", _unseen(EventKind.STATE_STALE)),
    Rule(Fault.HEARTBEAT, 1.5, Action.RETREAT, "HEARTBEAT_LOST, unless only the cameras see the vehicle",
         _unseen(EventKind.HEARTBEAT_LOST)),
    Rule(Fault.POSE_JUMPED, 0.0, Action.RETREAT, "pose LOST, and JUMPED", lambda seen, _: seen.pose_jumped),
    Rule(Fault.POSE, 0.05, Action.RETREAT, "pose LOST or NONE, or MOCAP_LOST",
         lambda seen, _: seen.pose in (PoseQuality.LOST, PoseQuality.NONE) or EventKind.MOCAP_LOST in seen.conditions),
    Rule(Fault.POSE_LATE, 0.2, Action.RETREAT, "in a mission, age of the poses over the oldest that the gains bear above",
         _above("pose_age", "pose_age", in_mission=True), ("pose_age",)),
    Rule(Fault.INCONSISTENT, 0.2, Action.RETREAT, "misfit of the held tip, in standard deviations, above",
         _above("misfit", "misfit"), ("misfit",)),
    Rule(Fault.BATTERY_CRITICAL, 1.0, Action.RETREAT, "charge below",
         lambda seen, limits: seen.battery < limits.critical_battery, ("critical_battery",)),
    Rule(Fault.CONTROLLER, 1.0, Action.RETREAT, "in a mission, age of the last command above",
         _above("command_age", "command_age", in_mission=True), ("command_age",)),
    Rule(Fault.FENCE, 0.05, Action.RETREAT, "position outside the box", _outside, ("fence",)),
    Rule(Fault.SPEED, 0.1, Action.RETREAT, "speed above", _above("speed", "speed"), ("speed",)),
    Rule(Fault.FORCE, 0.2, Action.RETREAT, "force of the surroundings above", _above("force", "force"), ("force",)),
    Rule(Fault.THRUST, 0.5, Action.RETREAT, "share of the largest thrust above", _above("thrust_share", "thrust_share"),
         ("thrust_share",)),
    Rule(Fault.SERVOS_JUMPED, 0.03, Action.RETREAT, "a servo's angle JUMPED",
         lambda seen, _: bool(seen.servo_fault & ServoFault.JUMPED)),
    Rule(Fault.SERVOS_DISCONNECTED, 0.1, Action.RETREAT, "servos DISCONNECTED or STOPPED",
         lambda seen, _: seen.servo_state in (BusState.DISCONNECTED, BusState.STOPPED)),
    Rule(Fault.GRIPPER, 0.1, Action.RETREAT, "gripper does not follow its command", lambda seen, _: seen.grip_failed),
    Rule(Fault.TELEMETRY, 1.0, Action.ABORT, "STATE_STALE, and a usable pose", _seen_only),
    Rule(Fault.TELEMETRY_GRIPPING, 0.4, Action.ABORT, "in a mission, STATE_STALE, a usable pose, and the gripper holds",
         lambda seen, _: seen.grips_unheard),
    Rule(Fault.SERVOS_FAILED, 0.1, Action.ABORT, "a servo has shut down", lambda seen, _: bool(seen.servo_fault & LATCHED)),
    Rule(Fault.SERVOS_STOPPED, 0.5, Action.ABORT, "in a mission, servos HOLDING, and not for want of commands", _servos_stopped),
    Rule(Fault.DEADLINES, 0.5, Action.ABORT, "in a mission, share of missed ticks above",
         _above("missed_ticks", "missed_ticks", in_mission=True), ("missed_ticks",)),
    Rule(Fault.BATTERY_LOW, 1.0, Action.ABORT, "charge below, or BATTERY_LOW",
         lambda seen, limits: seen.battery < limits.low_battery or EventKind.BATTERY_LOW in seen.conditions, ("low_battery",)),
    Rule(Fault.BATTERY_SILENT, 1.0, Action.ABORT, "BATTERY_SILENT", _conditions(EventKind.BATTERY_SILENT)),
)  # fmt: skip
"""What is looked at in every observation, the gravest first."""

ACTIONS: dict[Fault, Action] = {rule.fault: rule.action for rule in RULES} | {
    Fault.OPERATOR_ABORT: Action.ABORT,
    Fault.OPERATOR_LAND: Action.LAND,
    Fault.TERMINATED: Action.RETREAT,
    Fault.SESSION: Action.LAND,
    Fault.SESSION_SILENT: Action.RETREAT,
    Fault.MISSION_STUCK: Action.RETREAT,
}
"""Action of every fault, of those too that no observation shows."""


@dataclass(frozen=True)
class Finding:
    """A fault that lasted for as long as it may."""

    fault: Fault
    action: Action
    time: float
    """When it was found, by `time.monotonic` [s]."""
    lasted: float
    """Time for which it had held by then [s]."""

    def __str__(self) -> str:
        return f"{self.fault.value}: {self.action.name.lower()}"


class Assessor:
    """Rules with their memory; every fault is found once until it has passed.

    Args:
        limits: Bounds.
    """

    def __init__(self, limits: SafetySection) -> None:
        self.limits = limits
        self._since: dict[Fault, float] = {}
        self._found: set[Fault] = set()

    def assess(self, seen: Observation) -> list[Finding]:
        """Faults that are found in this observation.

        Args:
            seen: What is seen; not before the last one.

        Returns:
            New findings, the gravest action first; nothing while the vehicle is not armed.
        """
        if not seen.armed:
            self._since.clear()
            self._found.clear()
            return []
        findings = []
        for rule in RULES:
            if not rule.holds(seen, self.limits):
                self._since.pop(rule.fault, None)
                self._found.discard(rule.fault)
                continue
            lasted = seen.now - self._since.setdefault(rule.fault, seen.now)
            if lasted >= rule.patience - 1e-9 and rule.fault not in self._found:
                self._found.add(rule.fault)
                findings.append(Finding(rule.fault, rule.action, seen.now, lasted))
        return sorted(findings, key=lambda finding: -finding.action)
