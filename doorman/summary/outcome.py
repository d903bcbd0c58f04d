"""How a run ended: by the mission's own account, in truth, and in a sentence."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.doors.door import Door
from doorman.recording import Recording

OPEN_TOLERANCE = math.radians(2.0)
"""|α − target| below this counts as opened [rad]."""
KEPT_CONTACT = 0.9
"""A smaller share of time in contact is worth a word in the verdict."""
FLOWN = "flown to its end"
"""How the last message of a mission begins that went all its way; what it has seen of the door may follow."""
COMPLETED, TOUCHED, GOAL_MISSED, GIVEN_UP, CUT_OFF = "completed", "touched", "goal missed", "given up", "cut off"
"""Outcomes of a mission that went all its way and has opened the door in truth, of one that has touched something else meanwhile,
of one that went all its way and has not opened it, of one that retreated to the hover instead, and of one whose time was over."""
STANDS_FOR = 1.0
STANDS = math.radians(0.5)
"""A door that is faster on average [rad/s] in so long a time [s] before the flight's end does not stay where it is."""


def verdict(summary: dict[str, Any]) -> tuple[bool, str]:
    final, target = summary["final_door_angle_deg"], summary["target_door_angle_deg"]
    where = f"the door ended at {final:.1f}°, {abs(final - target):.1f}° from the target of {target:.1f}°"
    if summary["unit"] == "m":
        final, target = summary["final_opening"], summary["target_opening"]
        where = f"it ended {final:.3f} m open, {1e3 * abs(final - target):.0f} mm from the target of {target:.3f} m"
    if summary["collisions"]:
        return False, f"Something was touched ({summary['collisions']} contacts other than tip and leaf); {where}."
    if summary["min_clearance_m"] <= 0.0:
        return False, f"Shapes of vehicle and door overlap by {-summary['min_clearance_m'] * 1e3:.1f} mm; {where}."
    if summary["outcome"] == GIVEN_UP:
        return False, f"The mission was given up: {summary['reason']}; {where}."
    if not summary["opened"]:
        lost = summary["contact_fraction"] < KEPT_CONTACT
        why = f"the tip was on the leaf for only {summary['contact_fraction']:.0%} of the time and " if lost else ""
        more = f" ({summary['reason']})" if summary["outcome"] == GOAL_MISSED else ""
        return False, f"The door was not opened: {why}{where}{more}."
    passed = ", the vehicle is behind it" if summary["went_through"] else ""
    return True, f"The door was opened in {summary['time_to_open_s']:.2f} s{passed} and nothing was touched; {where}."


def judged(
    recording: Recording, door: Door, time: Array, angle: Array, moving: float, target: float, turned: float
) -> tuple[str, str, float | None]:
    """Outcome, its reason, and when the door came to its goal to stay, by its angles and its rate at the end.

    The same creep of the tip turns a lever `turned` times as fast as a leaf.
    """
    opened_at = time_to_open(time, angle, target) if abs(moving) < STANDS * turned else None
    outcome, reason = reported_outcome(recording)
    if outcome == COMPLETED and opened_at is None:
        outcome, reason = GOAL_MISSED, missed(door, float(angle[-1]), target, moving, reason)
    return outcome, reason, opened_at


def is_cut_off(summary: dict[str, Any]) -> bool:
    """Whether a flight's time was over before its mission, and nothing had been touched."""
    return summary["outcome"] == CUT_OFF and not summary["collisions"] and summary["min_clearance_m"] > 0.0


def time_to_open(time: Array, angle: Array, target: float) -> float | None:
    """First time after which |α − target| stays below 2°."""
    off = np.flatnonzero(np.abs(angle - target) >= OPEN_TOLERANCE)
    if len(off) == 0:
        return float(time[0])
    return float(time[off[-1] + 1]) if off[-1] + 1 < len(time) else None


def rate_at_the_end(recording: Recording) -> float:
    """Rate of the door, on average over the last second [rad/s]."""
    truth = recording["truth"]
    return float(truth["door_rate"][truth.time >= truth.time[-1] - STANDS_FOR].mean())


def missed(door: Door, angle: float, target: float, moving: float, said: str) -> str:
    """Why a mission that went all its way has not opened the door."""
    if abs(angle - target) >= OPEN_TOLERANCE:
        why = f"the door ended at {door.in_words(angle)}"
    else:
        speed = f"{door.per_angle * moving:+.3f} m/s" if door.slides else f"{math.degrees(moving):+.1f}°/s"
        why = f"the door still moved at the end, at {speed}"
    return f"{why}; the mission said: {said}" if said else why


def reported_outcome(recording: Recording) -> tuple[str, str]:
    """How the mission ended by its own account."""
    mission = recording["mission"]
    states, words = [str(state) for state in mission["state"]], str(mission["message"][-1])
    if words == "interrupted" or words.startswith("failed: "):
        return words.split(":")[0], words
    if "done" not in states:
        return CUT_OFF, f"the flight ended in the phase {states[-2] if len(states) > 1 else states[-1]}"
    if words.startswith(FLOWN):
        return COMPLETED, words.removeprefix(FLOWN).lstrip(", ")
    return GIVEN_UP, words
