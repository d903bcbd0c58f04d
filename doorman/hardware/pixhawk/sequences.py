"""Steps of a flight, each with a time-out and a defined end: entering the companion mode, arming, take-off, landing."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from doorman.background import Opened
from doorman.clocks import LONGEST_WAIT, REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.authority import Authority
from doorman.hardware.pixhawk.config import HEARTBEAT, PROMPT, PixhawkConfig
from doorman.hardware.pixhawk.events import Outcome, OutcomeStatus
from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.link.stream import LONGEST_BLIND_HOLD, here
from doorman.hardware.pixhawk.parameters.protocol import prepare_attitude
from doorman.hardware.pixhawk.sample import LandedState
from doorman.hardware.pixhawk.setpoints import PositionSetpoint
from doorman.hardware.pixhawk.wire.messages import mavlink

LEAST_HEIGHT, MOST_HEIGHT = 0.2, 50.0
"""Lowest and highest take-off [m]."""
_TAKE_OFF_TRIES = 4
_ARRIVED = 3 * LEAST_HEIGHT / 4
"""Distance to the height of take-off that counts as arrived [m]."""
GROUND_PATIENCE = 4 * HEARTBEAT
"""On the ground so long without disarming by itself, a vehicle that is to land is disarmed [s]."""
_DONE = Outcome(OutcomeStatus.DONE)
_NOT_OURS = Outcome(OutcomeStatus.CONTROL_LOST, "doorman does not control the vehicle")


class FlightSteps(Opened):
    """Steps of a flight on a link to an autopilot."""

    def __init__(self, config: PixhawkConfig, clock: Clock = REAL_TIME) -> None:
        self.config, self._clock = config, clock
        self._link = Link(config, clock)

    def _await_autopilot(self) -> None:
        """Wait for heartbeat, attitude and clock; for a heartbeat alone where we only listen."""
        link, timeout = self._link, self.config.timeouts.open
        deadline = self._clock.now() + timeout
        needs: tuple[tuple[str, Callable[[], bool]], ...] = (
            ("heartbeat of a multirotor", lambda: link.identity is not None),
            ("attitude", lambda: link.tracker.sample.attitude_time > float("-inf")),
            ("answers to TIMESYNC", lambda: link.clock.synchronised),
        )
        for missing, found in needs[:1] if self.config.listen_only else needs:
            if link.until(found, max(0.0, deadline - self._clock.now())):
                continue
            hint = ": messages arrive, but none from a multirotor" if link.foreign else ""
            if link.codec is not None and link.codec.counters.bad_signatures:
                hint = ": messages arrive, but their signatures are missing or wrong (PX4 before 1.17 cannot sign)"
            raise BackendError(f"no {missing} within {timeout:g} s{hint}", field="pixhawk.connection",
                               given=self.config.connection)  # fmt: skip

    def engage(self, *, unarmed: bool = False) -> Outcome:
        """Enter the mode in which the autopilot obeys us: offboard or guided.

        Before, everything that attitude setpoints need is looked up: the thrust curve and ArduPilot's options.

        Args:
            unarmed: Whether a vehicle that a person has armed by then is left to this person.

        Returns:
            DONE once the heartbeat shows the mode.
        """
        link, timeouts = self._link, self.config.timeouts
        dialect = link.known_dialect
        if self.config.setpoints == "attitude" and (missing := prepare_attitude(link)):
            return Outcome(OutcomeStatus.NOT_READY, missing)
        if not link.until(lambda: link.tracker.sample.age(self._clock.now()) <= timeouts.state, HEARTBEAT):
            return Outcome(OutcomeStatus.NOT_READY, "no fresh position and attitude")
        if self.config.mocap and self._clock.now() - link.mocap.newest_time > timeouts.mocap:
            return Outcome(OutcomeStatus.NOT_READY, "no fresh pose from mocap")
        sample = link.tracker.sample
        if (place := here(sample)) is None:
            return Outcome(OutcomeStatus.NOT_READY, "the autopilot rebooted")
        deadline = self._clock.now() + timeouts.mode + timeouts.stream_before_mode
        if dialect.needs_stream or sample.armed and sample.landed is LandedState.IN_AIR:
            link.stream.hold(place)
        if dialect.needs_stream:
            link.until(lambda: not link.alive, timeouts.stream_before_mode)
        link.authority.prepare()
        return self._enter(deadline, lambda: unarmed and link.tracker.sample.armed)

    def _enter(self, deadline: float, taken: Callable[[], bool]) -> Outcome:
        """Ask for the companion mode until the heartbeat shows it, unless somebody takes the vehicle meanwhile."""
        link, authority, dialect = self._link, self._link.authority, self._link.known_dialect

        def prepares() -> bool:
            return authority.state is Authority.PREPARING and not taken()

        outcome = Outcome(OutcomeStatus.TIMED_OUT, f"{dialect.companion_mode} was not entered{dialect.mode_hint}")
        mode = dialect.mode_parameters(dialect.companion_mode)
        while self._clock.now() < deadline and link.alive and prepares():
            answer = link.command(mavlink.MAV_CMD_DO_SET_MODE, *mode, go_on=prepares)
            patience, left = self._until_shown(answer), max(0.0, deadline - self._clock.now())
            link.until(lambda: not prepares(), min(patience, left))
            outcome = outcome if answer.done else answer
        if authority.state is Authority.ENGAGED and not taken():
            return _DONE
        if authority.state is Authority.LOST:
            return Outcome(OutcomeStatus.CONTROL_LOST, "another mode was chosen, or the motors were stopped")
        authority.withdraw(self._clock.now())
        return Outcome(OutcomeStatus.CONTROL_LOST, "somebody has armed the vehicle") if taken() else outcome

    def arm(self, timeout: float | None = None) -> Outcome:
        """Arm; refused, it is tried again until the time is over.

        Args:
            timeout: [s]; by default that of the settings.

        Returns:
            DONE once the heartbeat shows it; otherwise with the autopilot's reasons.
        """
        link, authority = self._link, self._link.authority
        deadline = self._clock.now() + (self.config.timeouts.arming if timeout is None else timeout)

        def armed() -> bool:
            return link.tracker.sample.armed

        def may() -> bool:  # a vehicle that is to land is not armed
            return not authority.landing_requested and authority.state not in (Authority.LANDING, Authority.LOST)

        while True:
            if not may():
                return Outcome(OutcomeStatus.NOT_READY, "the vehicle is to land, or another mode was chosen")
            outcome = link.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0, go_on=lambda: may() and not armed())
            left = math.inf if outcome.done else max(LONGEST_WAIT, deadline - self._clock.now())
            if link.until(armed, min(self._until_shown(outcome), left)):
                return _DONE
            if self._clock.now() >= deadline or not link.alive:
                break
        if outcome.done:
            self.disarm()  # it may be armed all the same
            return Outcome(
                OutcomeStatus.TIMED_OUT, "the autopilot acknowledged, but its heartbeat does not show it armed"
            )
        return outcome

    def disarm(self) -> Outcome:
        """Disarm on the ground."""
        link = self._link
        link.authority.disarm_expected = True
        outcome = link.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0.0)
        link.authority.disarm_expected = outcome.done or outcome.status is OutcomeStatus.TIMED_OUT
        if outcome.done and not link.until(lambda: not link.tracker.sample.armed, self._until_shown(outcome)):
            words = "the autopilot acknowledged, but its heartbeat does not show it disarmed"
            return Outcome(OutcomeStatus.TIMED_OUT, words)
        return outcome

    def take_off(self, height: float) -> Outcome:
        """Climb and hold.

        Args:
            height: Above where the vehicle stands [m].

        Returns:
            DONE once the height is reached.

        Raises:
            BackendError: if the height is out of range.
        """
        if not LEAST_HEIGHT <= height <= MOST_HEIGHT:
            allowed = f"{LEAST_HEIGHT:g} to {MOST_HEIGHT:g} m"
            raise BackendError("not a height", field="height", given=height, allowed=allowed)
        link, authority, sample = self._link, self._link.authority, self._link.tracker.sample
        place = here(sample)
        if authority.state is not Authority.ENGAGED or not sample.armed or place is None:
            return Outcome(OutcomeStatus.NOT_READY, "take-off needs engage() and arm() first, and a position")
        target = float(place.position[2]) + height
        if link.known_dialect.takes_off_by_command:
            link.stream.stop()  # a setpoint would end ArduPilot's take-off
            outcome = self._take_off_by_command(height)
            if not outcome.done:
                return outcome
        elif not authority.if_engaged(lambda stream: stream.climb(place, height, self._clock.now())):
            return Outcome(OutcomeStatus.CONTROL_LOST, "before take-off")

        def arrived() -> bool:
            now, calm = link.tracker.sample, self.config.climb_rate / 2
            return abs(float(now.position[2]) - target) < _ARRIVED and abs(float(now.velocity[2])) < calm

        reached = link.until(lambda: arrived() or self._lost(), self.config.timeouts.take_off)
        if self._lost():
            return Outcome(OutcomeStatus.CONTROL_LOST, "during take-off")
        top = PositionSetpoint(np.array([*place.position[:2], target]), place.yaw)
        if not authority.hold(top if reached else here(link.tracker.sample) or top, latch=False):
            return Outcome(OutcomeStatus.CONTROL_LOST, "control was lost at the end of take-off")
        return _DONE if reached else Outcome(OutcomeStatus.TIMED_OUT, f"height {height:g} m was not reached")

    def _take_off_by_command(self, height: float) -> Outcome:
        """NAV_TAKEOFF; refused while the motors are still spooling up, it is asked for again."""
        # Where an acknowledgement got lost, the repeated command is refused although the vehicle climbs: its state decides.
        link, outcome = self._link, Outcome(OutcomeStatus.TIMED_OUT)

        def lifts() -> bool:
            return link.tracker.sample.landed in (LandedState.TAKING_OFF, LandedState.IN_AIR)

        def settled() -> bool:
            return self._lost() or lifts()

        for _ in range(_TAKE_OFF_TRIES):
            outcome = link.command(mavlink.MAV_CMD_NAV_TAKEOFF, *[0.0] * 6, height, go_on=lambda: not settled())
            if outcome.done or link.until(settled, HEARTBEAT):
                break
        return _DONE if lifts() and not self._lost() else outcome

    def hold(self, *, at: PositionSetpoint | None = None, latch: bool = False) -> Outcome:
        """Stay where the vehicle is, or go to a place and stay there, by position setpoints.

        Args:
            at: Where; here if not given, which a position of the last second tells.
            latch: Refuse the controller's setpoints until `resume`.
        """
        sample = self._link.tracker.sample
        if at is None and sample.age(self._clock.now()) < LONGEST_BLIND_HOLD:
            at = here(sample)
        if at is None:
            return Outcome(OutcomeStatus.NOT_READY, "no position and attitude of the last second")
        return _DONE if self._link.authority.hold(at, latch=latch) else _NOT_OURS

    def land(self) -> Outcome:
        """Land where the vehicle is, in the autopilot's own mode.

        Returns:
            DONE once it is disarmed; CONTROL_LOST if the vehicle is not ours.
        """
        link, authority = self._link, self._link.authority
        deadline, on_ground_since = self._clock.now() + self.config.timeouts.landing, None
        if link.tracker.sample.armed and not link.request_landing():
            return _NOT_OURS
        while True:
            if link.until(lambda: not link.tracker.sample.armed, PROMPT):
                authority.withdraw(self._clock.now())
                return _DONE
            if authority.state is Authority.LOST:
                return Outcome(OutcomeStatus.CONTROL_LOST, "while landing")
            now = self._clock.now()
            if now >= deadline or not link.alive:
                return Outcome(OutcomeStatus.TIMED_OUT, "the vehicle did not report that it has landed")
            on_ground = link.tracker.sample.landed is LandedState.ON_GROUND and authority.state is Authority.LANDING
            on_ground_since = (on_ground_since or now) if on_ground else None
            if on_ground_since is not None and now - on_ground_since > GROUND_PATIENCE:
                self.disarm()
                on_ground_since = None

    def _leave(self) -> None:
        """Land what still flies by our setpoints, and command nothing any more."""
        link = self._link
        flying = link.tracker.sample.armed and link.authority.state is Authority.ENGAGED
        if flying and link.config.on_stop == "land" and link.alive and link.request_landing():
            link.until(lambda: link.authority.state is not Authority.ENGAGED, self.config.timeouts.stop)
        link.authority.withdraw(self._clock.now())

    def _until_shown(self, answer: Outcome) -> float:
        """Longest wait for the heartbeat to show what was acknowledged, or for the next request of what was not [s]."""
        return self.config.timeouts.heartbeat if answer.done else HEARTBEAT

    def _lost(self) -> bool:
        return self._link.authority.state is not Authority.ENGAGED or not self._link.alive
