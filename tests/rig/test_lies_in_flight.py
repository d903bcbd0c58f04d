"""What lies in flight: cameras that jump or drift, poses that come late, servos and grippers that do not tell the truth.

Each flight has one lie, in one phase with contact. Nothing is touched, its cause is told, and none says that it is completed.
Only a gripper ties the tip to a circle: a drift is not told to a vehicle that pushes.
"""

from __future__ import annotations

import os
import threading
import time
from dataclasses import dataclass

import pytest
from flight_ends import Injection, call, put
from flight_rig import SCENARIO, Flight, FlightRig, until

from doorman.flight import End
from doorman.hardware.safety import Fault

GRIPS = SCENARIO == "paper"
JUMP = "rig.mocap.faults.jump"
STOPS = "rig.servos.plant._gripper._stops"
"""Angles between which the fingers can move."""
OPEN_STOPS = (0.0, 0.8)
HALF = 0.45
"""Angle at which a gripper is stuck: neither open nor closed [rad]."""


def jump(*by: float) -> Injection:
    """The cameras see the vehicle elsewhere from now on [m]."""
    return put(JUMP, by)


def drift(*rate: float) -> Injection:
    """The cameras' frame moves from now on [m/s]."""

    def inject(rig: FlightRig, flight: Flight) -> None:
        def move() -> None:
            began = time.monotonic()
            while flight.report is None and (spent := time.monotonic() - began) < 30.0:
                rig.far.set(JUMP, tuple(spent * part for part in rate))
                time.sleep(0.05)

        threading.Thread(target=move, daemon=True).start()

    return inject


def turn(servo: int, degrees: float) -> Injection:
    """A servo has another zero from now on."""
    return call("set_register", servo, "homing offset", round(degrees / 360.0 * 4096))


@dataclass(frozen=True)
class Lie:
    """One lie, where it begins, and as what it is told."""

    inject: Injection
    phase: str
    after: float
    """In that phase [s]."""
    told: Fault
    """What is found first."""
    felt: str = ""
    """With which words the mission gives up, where it feels it before."""


PHASES = {"touch": ("touch", 1.0), "swing": ("open", 1.5), "release": ("release", 0.5)}


def cases() -> dict[str, Lie]:
    """All flights, by name."""
    made: dict[str, Lie] = {}
    for size in (0.03, 0.1):
        for axis, by in (("x", (size, 0.0, 0.0)), ("y", (0.0, size, 0.0)), ("-y", (0.0, -size, 0.0))):
            for when in ("touch", "swing", "release"):
                made[f"jump {axis} {100 * size:g} cm, {when}"] = Lie(jump(*by), *PHASES[when], Fault.POSE_JUMPED)
    for size in (0.01, 0.02, 0.05) if GRIPS else ():
        for axis, by in (("x", (size, 0.0, 0.0)), ("y", (0.0, size, 0.0))):
            for when in ("touch", "swing", "release"):
                made[f"drift {axis} {100 * size:g} cm/s, {when}"] = Lie(drift(*by), *PHASES[when], Fault.INCONSISTENT)
    for number, (servo, degrees) in enumerate((s, d) for s in (1, 2, 3, 4) for d in (5.0, -5.0, 15.0, -15.0)):
        when = ("swing", "touch", "release")[number % 3]
        made[f"servo {servo} {degrees:+g}°, {when}"] = Lie(turn(servo, degrees), *PHASES[when], Fault.SERVOS_JUMPED)
    for when in ("touch", "swing"):
        made[f"poses 60 ms late, {when}"] = Lie(put("rig.mocap.faults.delay", 0.06), *PHASES[when], Fault.POSE_LATE)
    return made | grippers() if GRIPS else made


def grippers() -> dict[str, Lie]:
    """A gripper that lies, or is stuck."""
    stuck, loose = Fault.GRIPPER, "the gripper does not hold the leaf"
    return {
        "gripper +26°, swing": Lie(turn(5, 26.0), *PHASES["swing"], Fault.SERVOS_JUMPED),
        "gripper -26°, swing": Lie(turn(5, -26.0), *PHASES["swing"], Fault.SERVOS_JUMPED),
        "gripper stuck open, touch": Lie(put(STOPS, (0.0, 0.1)), "approach", 0.0, stuck, loose),
        "gripper opens, swing": Lie(call("set_spring", 3.0), *PHASES["swing"], stuck, loose),
        "gripper stuck half open, touch": Lie(put(STOPS, (0.0, HALF)), "approach", 0.0, stuck, loose),
        "gripper stuck half open, swing": Lie(put(STOPS, (HALF, 0.8)), *PHASES["swing"], stuck),
    }


LIES = cases()
ALL = os.environ.get("DOORMAN_LIES") == "all"
QUICK = (
    "jump y 3 cm, swing", "jump x 10 cm, touch", "drift y 5 cm/s, swing", "drift x 2 cm/s, touch", "servo 2 -15°, touch",
    "gripper +26°, swing", "gripper stuck half open, swing", "poses 60 ms late, swing",
)  # fmt: skip
"""One of each kind; DOORMAN_LIES=all in the environment has all of them flown."""


@pytest.fixture(autouse=True)
def fingers_as_they_were(rig: FlightRig):
    yield
    if GRIPS:
        rig.far.set(STOPS, OPEN_STOPS)


@pytest.mark.parametrize("name", LIES if ALL else [name for name in QUICK if name in LIES])
def test_what_lies_is_told_and_nothing_is_touched(rig: FlightRig, name: str) -> None:
    lie = LIES[name]
    flight = rig.flight().begin().until_phase(lie.phase)
    time.sleep(lie.after)
    lie.inject(rig, flight)
    report = flight.end()
    until(lambda: not rig.snapshot.motors, f"motors off: {flight.told()}")
    row = report, rig.collided, flight.told()
    assert not rig.collided, row
    assert report.end is End.LANDED, row
    assert not report.completed, row
    if lie.felt and report.message == lie.felt:
        return
    assert report.findings and report.findings[0].fault is lie.told, row
    assert report.message == lie.told.value, row
