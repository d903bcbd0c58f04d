"""What can go wrong in flight, how long it may last, and what is done about it: the fault table as data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum

import numpy as np

from doorman.hardware.dynamixel import LATCHED, BusState, ServoFault
from doorman.hardware.mocap import PoseQuality
from doorman.hardware.pixhawk import Authority, EventKind
from doorman.hardware.safety.observation import Observation
from doorman.scenario import SafetySection


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
    LINK = "the autopilot is not heard"
    HEARTBEAT = "the autopilot sends no heartbeats"
    STATE = "the autopilot's state is old"
    TELEMETRY = "the autopilot is not heard, but seen by the cameras"
    TELEMETRY_GRIPPING = "the autopilot is not heard, with the door in the gripper"
    POSE = "the cameras have lost the vehicle"
    DIVERGENCE = "cameras and autopilot disagree"
    DISOBEDIENCE = "the autopilot does not do what it is told, with the door in the gripper"
    TILT = "too much tilt"
    FENCE = "outside the fence"
    SPEED = "too fast"
    FORCE = "too much force on the vehicle"
    THRUST = "thrust is saturated"
    CONTROLLER = "the controller is silent"
    DEADLINES = "the controller misses its ticks"
    BATTERY_LOW = "the battery is low"
    BATTERY_CRITICAL = "the battery is nearly empty"
    BATTERY_SILENT = "the battery's charge is not told any more"
    SERVOS_DISCONNECTED = "the servos' device is gone"
    GRIPPER = "the gripper does not hold or let go of the door, or its servo has failed"
    SERVOS_FAILED = "a servo has failed"
    SERVOS_STOPPED = "the arm does not follow"
    OPERATOR_ABORT = "the operator gives up"
    OPERATOR_LAND = "the operator wants to land"
    TERMINATED = "the process is asked to end"
    SESSION = "nobody flies the vehicle back"
    SESSION_SILENT = "whoever flies the vehicle is silent"
    MISSION_STUCK = "the mission does not end"


@dataclass(frozen=True)
class Rule:
    """One row of the table."""

    fault: Fault
    patience: float
    """For how long it must hold [s]."""
    action: Action
    holds: Callable[[Observation, SafetySection], bool]
    """Whether it holds now."""


def _conditions(*kinds: EventKind) -> Callable[[Observation, SafetySection], bool]:
    return lambda seen, _: not seen.conditions.isdisjoint(kinds)


def _outside(seen: Observation, limits: SafetySection) -> bool:
    return bool((seen.position < limits.fence_low).any() or (seen.position > limits.fence_high).any())


def _seen_only(seen: Observation, _: SafetySection) -> bool:
    """Whether only the cameras say where the vehicle is: it can be flown by them."""
    return seen.pose is not None and seen.pose.usable and EventKind.STATE_STALE in seen.conditions


def _unseen(kind: EventKind) -> Callable[[Observation, SafetySection], bool]:
    return lambda seen, limits: kind in seen.conditions and not _seen_only(seen, limits)


def _servos_stopped(seen: Observation, _: SafetySection) -> bool:
    return seen.commanding and seen.servo_state is BusState.HOLDING and not seen.servo_fault & ServoFault.COMMAND_STALE


RULES: tuple[Rule, ...] = (
    Rule(Fault.PILOT, 0.0, Action.RELEASE, lambda seen, _: seen.authority is Authority.LOST),
    Rule(Fault.LINK, 10.0, Action.RELEASE, _conditions(EventKind.LINK_LOST, EventKind.DEVICE_LOST)),
    Rule(Fault.TILT, 0.05, Action.LAND, lambda seen, limits: seen.tilt > limits.tilt),
    Rule(Fault.DIVERGENCE, 0.3, Action.RETREAT, lambda seen, limits: seen.divergence > limits.divergence),
    Rule(Fault.DISOBEDIENCE, 0.2, Action.RETREAT,
         lambda seen, limits: seen.commanding and seen.disobedience > limits.disobedience),
    Rule(Fault.STATE, 0.3, Action.RETREAT, _unseen(EventKind.STATE_STALE)),
    Rule(Fault.HEARTBEAT, 1.5, Action.RETREAT, _unseen(EventKind.HEARTBEAT_LOST)),
    Rule(Fault.POSE, 0.05, Action.RETREAT,
         lambda seen, _: seen.pose in (PoseQuality.LOST, PoseQuality.NONE) or EventKind.MOCAP_LOST in seen.conditions),
    Rule(Fault.BATTERY_CRITICAL, 1.0, Action.RETREAT, lambda seen, limits: seen.battery < limits.critical_battery),
    Rule(Fault.CONTROLLER, 1.0, Action.RETREAT,
         lambda seen, limits: seen.commanding and seen.command_age > limits.command_age),
    Rule(Fault.FENCE, 0.05, Action.RETREAT, _outside),
    Rule(Fault.SPEED, 0.1, Action.RETREAT, lambda seen, limits: seen.speed > limits.speed),
    Rule(Fault.FORCE, 0.2, Action.RETREAT, lambda seen, limits: seen.force > limits.force),
    Rule(Fault.THRUST, 0.5, Action.RETREAT, lambda seen, limits: seen.thrust_share > limits.thrust_share),
    Rule(Fault.SERVOS_DISCONNECTED, 0.1, Action.RETREAT,
         lambda seen, _: seen.servo_state in (BusState.DISCONNECTED, BusState.STOPPED)),
    Rule(Fault.GRIPPER, 0.1, Action.RETREAT, lambda seen, _: seen.grip_failed),
    Rule(Fault.TELEMETRY, 1.0, Action.ABORT, _seen_only),
    Rule(Fault.TELEMETRY_GRIPPING, 0.4, Action.ABORT, lambda seen, _: seen.grips_unheard),
    Rule(Fault.SERVOS_FAILED, 0.1, Action.ABORT, lambda seen, _: bool(seen.servo_fault & LATCHED)),
    Rule(Fault.SERVOS_STOPPED, 0.5, Action.ABORT, _servos_stopped),
    Rule(Fault.DEADLINES, 0.5, Action.ABORT,
         lambda seen, limits: seen.commanding and seen.missed_ticks > limits.missed_ticks),
    Rule(Fault.BATTERY_LOW, 1.0, Action.ABORT,
         lambda seen, limits: seen.battery < limits.low_battery or EventKind.BATTERY_LOW in seen.conditions),
    Rule(Fault.BATTERY_SILENT, 1.0, Action.ABORT, _conditions(EventKind.BATTERY_SILENT)),
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


def finite(values: np.ndarray) -> bool:
    """Whether all values are numbers."""
    return bool(np.isfinite(values).all())
