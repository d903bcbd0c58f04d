"""Supervisor: a thread that watches the flight and takes the vehicle from the mission when a rule is broken."""

from __future__ import annotations

import contextlib
import threading
import traceback
from collections.abc import Callable

import numpy as np

from doorman.arrays import Array
from doorman.background import EventLog, InThread
from doorman.exceptions import BackendError, DoormanError
from doorman.hardware.pixhawk import Authority
from doorman.hardware.pixhawk.setpoints import StraightWay
from doorman.hardware.safety.rules import ACTIONS, Action, Assessor, Fault, Finding, Observation
from doorman.hardware.vehicle.links import DRIFTS_FOR, VehicleLinks
from doorman.scenario import SafetySection

ACKNOWLEDGE_WITHIN = 1.5
"""A session must fly the vehicle back within this after a retreat was ordered, else it lands [s]."""
SILENT_WITHIN = 8.0
"""Time-out of a session's signs of life; then the supervisor flies the vehicle back. Setting up a gripper takes less [s]."""
ABORT_WITHIN = 20.0
"""A mission that was asked to give up must have ended after this [s]."""

_LETTING_GO = 5.0
"""Longest time for the gripper to open before that [s]."""
_SETTLING = 1.0
"""Time for the vehicle to settle at the end of that way [s]."""
OnAbort = Callable[[str], None]
"""Asks the mission to give up, with the reason."""


class Supervisor(InThread):
    """Watches links and vehicle at its own pace, and acts by itself.

    It knows neither planner nor controller. A mission that it does not trust any more loses the vehicle (`VehicleLinks.inhibit`);
    landing is ordered by the supervisor's own thread, whatever the others do. While it sees something it says so to the links,
    without which the backend flies no mission.

    Args:
        links: The vehicle's links.
        look: Makes observations.
        limits: Bounds.
        period: Between two looks [s].
        refuge: Place to land from a position, each of shape (3,), world frame [m], out of the doorway in a straight line: for a
            retreat that no session flies. It lands where it is if not given.
    """

    def __init__(
        self,
        links: VehicleLinks,
        look: Callable[[], Observation],
        limits: SafetySection | None = None,
        period: float = 0.02,
        refuge: Callable[[Array], Array] | None = None,
    ) -> None:
        super().__init__("supervisor", links.clock)
        self._links, self._look, self._period, self._refuge = links, look, period, refuge
        self._leaving: StraightWay | None = None
        self._assessor = Assessor(limits or SafetySection())
        self._lock = self._clock.lock()
        self._on_abort: OnAbort | None = None
        self._aborted_at: float | None = None
        self._cause: Finding | None = None
        self._ordered_at: float | None = None
        self._acknowledged = False
        self._alive_at: float | None = None
        self._wishes = EventLog[Fault]()
        self._printed = False
        self.rising = False
        """Whether the vehicle has not reached its hover point yet: a retreat lands it where it is."""
        self.action: Action | None = None
        """Gravest action so far; None as long as all is well."""
        self.findings: list[Finding] = []
        """Everything that was found, oldest first."""

    # ------------------------------------------------------------ life

    def open(self) -> None:
        """Begin to watch.

        Raises:
            BackendError: if it watches already.
        """
        super().open()

    def stop(self) -> None:
        """Watch no more; may be called twice."""
        super().stop()
        self._links.guard(None)

    def _begin(self) -> None:
        self._acknowledged, self._alive_at = False, None
        self._links.guard(self._clock.now())

    # ------------------------------------------------------------ what others say to it

    def watch_mission(self, on_abort: OnAbort | None) -> None:
        """Name the mission that is asked to give up; without one, it loses the vehicle instead.

        Args:
            on_abort: Asks it, with the reason; None where no mission flies.
        """
        with self._lock:
            self._on_abort, self._aborted_at = on_abort, None

    def report(self, fault: Fault) -> None:
        """Tell of a fault that the links do not show, such as the operator's wish.

        Args:
            fault: What.
        """
        self._take(Finding(fault, ACTIONS[fault], self._clock.now(), 0.0))

    def wish(self, fault: Fault) -> None:
        """Report a fault from a signal's handler, which may interrupt whoever holds a lock: it is heeded at the next look.

        Args:
            fault: What.
        """
        self._wishes.write(fault)

    def acknowledge(self) -> None:
        """Say, again and again, that a session flies the vehicle back: without that a retreat ends in a landing."""
        self._heed()
        with self._lock:  # after this, no hold is latched any more that was decided before
            self._acknowledged, self._alive_at = True, self._clock.now()

    def hand_over(self) -> None:
        """Say that the vehicle is at its hover point: from now on the supervisor notices when no program flies it."""
        with self._lock:
            self.rising, self._alive_at = False, self._clock.now()

    @property
    def reason(self) -> str:
        """The fault behind the gravest action, in words; empty as long as all is well."""
        with self._lock:
            return "" if self._cause is None else self._cause.fault.value

    # ------------------------------------------------------------ the thread

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                self.look_once()
            except DoormanError:
                pass  # a link that was closed meanwhile: nothing to look at
            except Exception as error:  # it goes on watching, as far as it can
                self._tell(error)
            else:
                self._links.guard(self._clock.now())
            self._stopping.wait(self._period)

    def _tell(self, error: Exception) -> None:
        """Print what only a mistake in this program can be, once."""
        if not self._printed:
            self._printed = True  # in a thread of its own: a terminal may take nothing
            threading.Thread(target=traceback.print_exception, args=(error,), daemon=True).start()

    def _heed(self) -> None:
        for fault in self._wishes.take():
            self.report(fault)

    def look_once(self) -> None:
        """One look, and what follows from it."""
        self._heed()
        seen = self._look()
        for finding in self._assessor.assess(seen):
            self._take(finding)
        with self._lock:
            self._watch_those_who_act(seen)

    def _take(self, finding: Finding) -> None:
        with self._lock:
            self.findings.append(finding)
            if self.action is not None and finding.action <= self.action:
                return
            self.action, self._cause = finding.action, finding
            if finding.fault is Fault.INCONSISTENT:
                self._links.doubt.distrust()  # whoever lies: what the autopilot feels is sure for a while
            self._act(finding)

    def _act(self, finding: Finding) -> None:
        if finding.action is Action.ABORT:
            if self._on_abort is not None:
                self._aborted_at = finding.time
                self._on_abort(finding.fault.value)
                return
            self.action = Action.RETREAT  # no mission that could give up by itself
        if self.action is Action.RETREAT and self.rising:
            self.action = Action.LAND
        self._links.inhibit(finding.fault.value)
        if self.action is Action.RETREAT:
            self._ordered_at, self._leaving = finding.time, None
            if not self._acknowledged:  # else the vehicle is on its way back already
                with contextlib.suppress(BackendError):
                    self._links.hold(latch=True)
        elif self.action is Action.LAND:
            self._links.autopilot.request_landing()

    def _watch_those_who_act(self, seen: Observation) -> None:
        if seen.commanding:
            self._alive_at = seen.now
        flies = seen.armed and seen.authority is Authority.ENGAGED
        if flies and self._alive_at is not None and seen.now - self._alive_at > SILENT_WITHIN:
            self._acknowledged, self._alive_at = False, None
            self._ordered_at, self._leaving = seen.now, None
            self.report(Fault.SESSION_SILENT)
        if self.action in (Action.LAND, Action.RELEASE):
            self._links.let_go()  # a vehicle that holds on to the door cannot come down
        if self.action is Action.ABORT and self._aborted_at is not None:
            if seen.commanding and seen.now - self._aborted_at > ABORT_WITHIN:
                self.report(Fault.MISSION_STUCK)
        elif self.action is Action.RETREAT and self._ordered_at is not None and seen.armed:
            waited = seen.now - self._ordered_at
            if not self._acknowledged and waited > ACKNOWLEDGE_WITHIN:
                self._leave(seen.now, waited)
        elif self.action is Action.LAND and seen.armed and seen.authority is Authority.ENGAGED:
            self._links.autopilot.request_landing()

    def _leave(self, now: float, waited: float) -> None:
        """Fly straight to the refuge and land there: no session has acknowledged the retreat in the time waited [s]."""
        self._links.let_go()
        if self._links.holding:  # to fly away would pull on the door
            if waited > ACKNOWLEDGE_WITHIN + _LETTING_GO:
                self.report(Fault.SESSION)
            return
        if self._leaving is None and self._refuge is not None:
            where = self._links.whereabouts()
            if not where.known and waited < ACKNOWLEDGE_WITHIN + DRIFTS_FOR:
                return
            if np.isfinite(where.position).all():
                self._leaving = StraightWay(now, where.position, self._refuge(where.position), where.yaw, where.yaw)
        leaving, hold = self._leaving, self._links.autopilot.hold
        if leaving is None or now - leaving.since > leaving.duration + _SETTLING:
            self.report(Fault.SESSION)
        elif not hold(at=leaving.setpoint(now), latch=True).done:
            self.report(Fault.SESSION)
