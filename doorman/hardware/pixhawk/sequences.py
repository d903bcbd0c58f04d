"""What takes several steps: entering the companion mode, arming, take-off, landing, measuring thrust.

Each has a time-out and a defined end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.authority import Authority
from doorman.hardware.pixhawk.events import Outcome, OutcomeStatus
from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.link.stream import LONGEST_BLIND_HOLD, here
from doorman.hardware.pixhawk.sample import LandedState, VehicleSample
from doorman.hardware.pixhawk.setpoints import PositionSetpoint
from doorman.hardware.pixhawk.thrust.curve import ThrustCurve, hover_curve
from doorman.hardware.pixhawk.thrust.slope import BOB_TIME, Slope, bob, measured_slope
from doorman.hardware.pixhawk.wire.messages import mavlink

_HEARTBEAT_WAIT = 2.5
"""Longest wait for the heartbeat to show what was acknowledged: it comes once a second and may get lost [s]."""
_PATIENCE = 1.0
"""Longest wait for a fresh state before the mode is requested [s]."""
_RETRY = 1.0
"""Time between two requests that the autopilot may accept later [s]."""
_TAKE_OFF_TRIES = 4
_ARRIVED = 0.15
"""Distance to the height of take-off that counts as arrived [m]."""
_CALM = 0.3
"""Vertical speed that counts as arrived [m/s]."""
_GROUND_PATIENCE = 4.0
"""On the ground so long without disarming by itself, the adapter disarms the vehicle [s]."""
_BOB_PERIOD = 0.02
"""Time between setpoints of a bob [s]."""
_DONE = Outcome(OutcomeStatus.DONE)


def await_autopilot(link: Link) -> None:
    """Wait for heartbeat, attitude and clock; for a heartbeat alone where we only listen."""
    timeout = link.config.timeouts.open
    deadline = link.time.now() + timeout
    needs: tuple[tuple[str, Callable[[], bool]], ...] = (
        ("heartbeat of a multirotor", lambda: link.identity is not None),
        ("attitude", lambda: link.tracker.sample.attitude_time > float("-inf")),
        ("answers to TIMESYNC", lambda: link.clock.synchronised),
    )
    for missing, found in needs[:1] if link.config.listen_only else needs:
        if not link.until(found, max(0.0, deadline - link.time.now())):
            raise BackendError(
                f"no {missing} within {timeout:g} s{_hint(link)}",
                field="pixhawk.connection",
                given=link.config.connection,
            )


def _hint(link: Link) -> str:
    if link.codec is not None and link.codec.counters.bad_signatures:
        return ": messages arrive, but their signatures are missing or wrong (PX4 before 1.17 cannot sign)"
    if link.foreign:
        return ": messages arrive, but none from a multirotor"
    return ""


def engage(link: Link, unarmed: bool = False) -> Outcome:
    timeouts = link.config.timeouts
    if not link.until(lambda: link.tracker.sample.age(link.time.now()) <= timeouts.state, _PATIENCE):
        return Outcome(OutcomeStatus.NOT_READY, "no fresh position and attitude")
    if link.config.mocap and link.time.now() - link.mocap.newest_time > timeouts.mocap:
        return Outcome(OutcomeStatus.NOT_READY, "no fresh pose from mocap")
    sample = link.tracker.sample
    place = here(sample)
    if place is None:
        return Outcome(OutcomeStatus.NOT_READY, "the autopilot rebooted")
    dialect = link.known_dialect
    deadline = link.time.now() + timeouts.mode + timeouts.stream_before_mode
    if dialect.needs_stream or sample.armed and sample.landed is LandedState.IN_AIR:
        link.stream.hold(place)
    if dialect.needs_stream:
        link.until(lambda: not link.alive, timeouts.stream_before_mode)
    outcome = Outcome(OutcomeStatus.TIMED_OUT, f"{dialect.companion_mode} was not entered{dialect.mode_hint}")
    link.authority.prepare()

    def taken() -> bool:
        return unarmed and link.tracker.sample.armed

    def prepares() -> bool:
        return link.authority.state is Authority.PREPARING and not taken()

    while link.time.now() < deadline and link.alive and prepares():
        answer = link.command(
            mavlink.MAV_CMD_DO_SET_MODE, *dialect.mode_parameters(dialect.companion_mode), go_on=prepares
        )
        wait = min(_HEARTBEAT_WAIT if answer.done else _RETRY, max(0.0, deadline - link.time.now()))
        link.until(lambda: not prepares(), wait)
        if not answer.done:
            outcome = answer
    if link.authority.state is Authority.ENGAGED and not taken():
        return _DONE
    if link.authority.state is Authority.LOST:
        return Outcome(OutcomeStatus.CONTROL_LOST, "another mode was chosen, or the motors were stopped")
    link.authority.withdraw(link.time.now())
    return Outcome(OutcomeStatus.CONTROL_LOST, "somebody has armed the vehicle") if taken() else outcome


def arm(link: Link, timeout: float) -> Outcome:
    """Ask to arm until the autopilot accepts it or the time is over, and see it in the heartbeat."""
    # A vehicle that is to land is not armed.
    deadline = link.time.now() + timeout
    while True:
        if not _may_arm(link):
            return Outcome(OutcomeStatus.NOT_READY, "the vehicle is to land, or another mode was chosen")
        outcome = link.command(
            mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0,
            go_on=lambda: _may_arm(link) and not link.tracker.sample.armed,
        )  # fmt: skip
        wait = _HEARTBEAT_WAIT if outcome.done else min(_RETRY, max(0.1, deadline - link.time.now()))
        if link.until(lambda: link.tracker.sample.armed, wait):
            return _DONE
        if link.time.now() >= deadline or not link.alive:
            break
    if outcome.done:
        disarm(link)  # it may be armed all the same
        return Outcome(OutcomeStatus.TIMED_OUT, "the autopilot acknowledged, but its heartbeat does not show it armed")
    return outcome


def _may_arm(link: Link) -> bool:
    return not link.authority.landing_requested and link.authority.state not in (Authority.LANDING, Authority.LOST)


def disarm(link: Link) -> Outcome:
    """Disarm; autopilots refuse it in the air."""
    link.authority.expect_disarm(True)
    outcome = link.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0.0)
    link.authority.expect_disarm(outcome.done or outcome.status is OutcomeStatus.TIMED_OUT)
    if outcome.done and not link.until(lambda: not link.tracker.sample.armed, _HEARTBEAT_WAIT):
        return Outcome(
            OutcomeStatus.TIMED_OUT, "the autopilot acknowledged, but its heartbeat does not show it disarmed"
        )
    return outcome


def take_off(link: Link, height: float) -> Outcome:
    """Climb by a height from where the vehicle stands, and hold there."""
    sample = link.tracker.sample
    place = here(sample)
    if link.authority.state is not Authority.ENGAGED or not sample.armed or place is None:
        return Outcome(OutcomeStatus.NOT_READY, "take-off needs engage() and arm() first, and a position")
    target = float(place.position[2]) + height
    if link.known_dialect.takes_off_by_command:
        link.stream.stop()  # a setpoint would end ArduPilot's take-off
        outcome = _take_off_by_command(link, height)
        if not outcome.done:
            return outcome
    elif not link.authority.climb(place, height, link.time.now()):
        return Outcome(OutcomeStatus.CONTROL_LOST, "before take-off")

    def arrived() -> bool:
        now = link.tracker.sample
        return abs(float(now.position[2]) - target) < _ARRIVED and abs(float(now.velocity[2])) < _CALM

    reached = link.until(lambda: arrived() or _lost(link), link.config.timeouts.take_off)
    if _lost(link):
        return Outcome(OutcomeStatus.CONTROL_LOST, "during take-off")
    top = PositionSetpoint(np.array([*place.position[:2], target]), place.yaw)
    if not link.authority.hold(top if reached else here(link.tracker.sample) or top, latch=False):
        return Outcome(OutcomeStatus.CONTROL_LOST, "control was lost at the end of take-off")
    return _DONE if reached else Outcome(OutcomeStatus.TIMED_OUT, f"height {height:g} m was not reached")


def _take_off_by_command(link: Link, height: float) -> Outcome:
    """NAV_TAKEOFF; refused while the motors are still spooling up, it is asked for again."""
    # Where an acknowledgement got lost, the repeated command is refused although the vehicle climbs: its state decides.
    outcome = Outcome(OutcomeStatus.TIMED_OUT)

    def lifts() -> bool:
        return link.tracker.sample.landed in (LandedState.TAKING_OFF, LandedState.IN_AIR)

    for _ in range(_TAKE_OFF_TRIES):
        outcome = link.command(
            mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, height, go_on=lambda: not (_lost(link) or lifts())
        )
        if outcome.done or link.until(lambda: _lost(link) or lifts(), _RETRY):
            break
    return _DONE if lifts() and not _lost(link) else outcome


def hold(link: Link, at: PositionSetpoint | None, latch: bool) -> Outcome:
    """Stay at a place, or where the vehicle is, which a position of the last second tells."""
    sample = link.tracker.sample
    if at is None and sample.age(link.time.now()) < LONGEST_BLIND_HOLD:
        at = here(sample)
    if at is None:
        return Outcome(OutcomeStatus.NOT_READY, "no position and attitude of the last second")
    if not link.authority.hold(at, latch=latch):
        return Outcome(OutcomeStatus.CONTROL_LOST, "doorman does not control the vehicle")
    return _DONE


def land(link: Link) -> Outcome:
    """Ask for the landing mode until the heartbeat shows it, then wait until the vehicle is disarmed on the ground."""
    authority, deadline = link.authority, link.time.now() + link.config.timeouts.landing
    if not link.tracker.sample.armed:
        authority.withdraw(link.time.now())
        return _DONE
    if not link.request_landing():
        return Outcome(OutcomeStatus.CONTROL_LOST, "doorman does not control the vehicle")
    on_ground_since: float | None = None
    while link.time.now() < deadline and link.alive:
        if link.until(lambda: not link.tracker.sample.armed, 0.2):
            authority.withdraw(link.time.now())
            return _DONE
        if authority.state is Authority.LOST:
            return Outcome(OutcomeStatus.CONTROL_LOST, "while landing")
        on_ground = link.tracker.sample.landed is LandedState.ON_GROUND and authority.state is Authority.LANDING
        on_ground_since = (on_ground_since or link.time.now()) if on_ground else None
        if on_ground_since is not None and link.time.now() - on_ground_since > _GROUND_PATIENCE:
            disarm(link)
            on_ground_since = None
    return Outcome(OutcomeStatus.TIMED_OUT, "the vehicle did not report that it has landed")


def leave(link: Link) -> None:
    flying = link.tracker.sample.armed and link.authority.state is Authority.ENGAGED
    if flying and link.config.on_stop == "land" and link.alive and link.request_landing():
        link.until(lambda: link.authority.state is not Authority.ENGAGED, link.config.timeouts.stop)
    link.authority.withdraw(link.time.now())


def _heard(link: Link, duration: float) -> list[VehicleSample]:
    """The samples of a while, as they come."""
    samples: list[VehicleSample] = []

    def note() -> bool:
        samples.append(link.tracker.sample)
        return False

    link.until(note, duration)
    return samples


def measure_hover(link: Link, hover_force: float, duration: float, *, compensate_battery: bool) -> ThrustCurve:
    old = link.stream.curve
    curve = hover_curve(_heard(link, duration), hover_force, 0.0 if old is None else old.shape, compensate_battery)
    if old is not None:
        curve = replace(
            old, hover_thrust=curve.hover_thrust, hover_force=hover_force, hover_voltage=curve.hover_voltage
        )
    link.stream.curve = curve
    return curve


def measure_slope(link: Link, at: PositionSetpoint) -> Slope | None:
    """Measure how steeply thrust grows with its setpoint, by bobbing up and aside a little; the vehicle must hold."""
    curve, samples = link.stream.curve, list[VehicleSample]()
    begin = link.time.now()
    while (passed := link.time.now() - begin) < BOB_TIME:
        if not link.stream.offer(bob(at, passed), link.time.now()):
            return None
        samples += _heard(link, _BOB_PERIOD)
    if not link.authority.hold(at, latch=False):
        return None
    return None if curve is None else measured_slope(samples, curve.hover_thrust)


def _lost(link: Link) -> bool:
    return link.authority.state is not Authority.ENGAGED or not link.alive
