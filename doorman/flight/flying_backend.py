"""The vehicle as a backend that takes off when it is opened and lands when it is stopped, under supervision all the time."""

from __future__ import annotations

import logging
import math
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import Any

from doorman.clocks import LOOK
from doorman.door_sensor.config import PROGRAM
from doorman.exceptions import BackendError
from doorman.feasibility import check
from doorman.flight.ends import End
from doorman.flight.ground.checklist import preflight
from doorman.flight.ground.judgements import Check, Verdict
from doorman.flight.ground.rehearsal import rehearse
from doorman.flight.guarded import SAME_INTERRUPT, STOPPING, GuardedFlight
from doorman.hardware.door import DoorSource
from doorman.hardware.interface import Backend, Command, Measurement
from doorman.hardware.mocap import PoseSource
from doorman.hardware.safety import Fault
from doorman.hardware.scheduling import real_time
from doorman.hardware.vehicle import TipForceSource, VehicleConfig, VehicleLinks, vehicle_config
from doorman.hardware.vehicle.config import DOOR_SENSOR
from doorman.hardware.vehicle.waiting import await_links
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.recording import Recorder


class FlyingBackend(Backend):
    """Everything that `doorman fly` does around a mission, for programs that fly one by themselves.

    From `open` to `stop`, SIGTERM and SIGHUP raise SystemExit in a program that has no handlers of its own for them, as Ctrl-C
    raises KeyboardInterrupt: where either reaches `stop`, as a mission's does, the vehicle flies back first.

    Args:
        model: Model of the scenario.
        pixhawk: Connection to the autopilot, such as `udp:14540`; or all links, as `VehicleFile.links` configures them.
        servos: Serial device of the arm.
        mocap: Where the cameras' stream is received, such as `udp:51001`; None flies on the autopilot's own estimate.
        recorder: Gets what the links and the supervisor tell; written by the thread that flies, as a mission's is.
        say: Called with the checklist's warnings and of every step by the thread that flies, so it must not block; by default the
            warnings go to Python's log.
        confirm: Called once the checklist is passed, with all of its rows, whether to arm and fly; it is flown by default.
        tip_force: Reads a force sensor in a tip without a gripper, if there is one.
        door: Measures the door, in place of what the configuration names as its sensor.
        poses: Brings the vehicle's poses, in place of the cameras that `mocap` names.
        settings: Fields of `vehicle_config` by dotted name, such as `servos.directions` and `servos.zero_positions`.
    """

    real_time = True
    comes_back = True

    def __init__(
        self,
        model: Model,
        pixhawk: str | VehicleConfig,
        servos: str = "",
        mocap: str | None = None,
        *,
        recorder: Recorder | None = None,
        say: Callable[[str], None] | None = None,
        confirm: Callable[[list[Check]], bool] = lambda checks: True,
        tip_force: TipForceSource | None = None,
        door: DoorSource | None = None,
        poses: PoseSource | None = None,
        settings: Mapping[str, object] | None = None,
    ) -> None:
        self._model = model
        if isinstance(pixhawk, str):
            if door is not None:
                settings = {f"{DOOR_SENSOR}.source": PROGRAM, **(settings or {})}
            pixhawk = vehicle_config(model, pixhawk, servos, mocap, on_mocap_loss="report", links=settings)
        self.links = VehicleLinks(pixhawk, tip_force, door=door, poses=poses)
        self._closing, self._stopping = ExitStack(), False
        self._recorder, self._say, self._confirm = recorder or Recorder(None, {}), say, confirm
        self._abort: Callable[[str], None] | None = None
        self._taken = -math.inf
        self.flight = self._new_flight()
        """The latest one: its supervisor has the findings, its journal the events."""
        self.end: End | None = None
        """How it ended; None before."""

    def watch_mission(self, abort: Callable[[str], None]) -> None:
        """Name the mission that is to give up, where its controller may still fly back; without one, it loses the vehicle.

        Args:
            abort: Makes it give up.
        """
        self._abort = abort

    @property
    def feedback_lag(self) -> float:
        """Feedback lag of the autopilot that answers [s]; see `Backend`."""
        return self.links.autopilot.status().feedback_lag

    def open(self) -> None:
        """Open the links, go through the checklist, arm, take off and fly to the hover point.

        Raises:
            BackendError: if a link cannot be opened, the checklist is not passed or the flight not confirmed, or the vehicle
                does not get to the hover point. It is on the ground then, or the error has a note that says where else.
        """
        if self.links.is_open:
            raise BackendError(
                "the vehicle flies already: a mission opens its backend itself", allowed="stop() before another open()"
            )
        try:
            self.flight, self.end, self._stopping = self._new_flight(), None, False
            findings = check(self._model)
            rehearse(self._model, Planner(self._model))  # nothing is compiled in the air
            self._closing.enter_context(_ended_by_exceptions(lambda: not self._stopping))
            self._closing.enter_context(real_time())
            self._closing.callback(self.links.stop)
            self.links.open()
            await_links(self.links)
            self._go_through(preflight(self._model, self.links, findings))
            self.flight.begin()
            reason = self.flight.rise()
            if reason:
                raise BackendError(reason, field="take-off")
            if self._abort is not None:
                self.flight.supervisor.watch_mission(self._abort)
            self.flight.backend.open()
        except BaseException as error:
            if self.flight.supervisor.rising and not isinstance(error, Exception):
                self.flight.supervisor.report(Fault.OPERATOR_LAND)  # its way has not begun
            try:
                self.stop()
            except BackendError as worse:
                error.add_note(str(worse))
            raise

    def read(self) -> Measurement:
        """As `VehicleBackend.read`."""
        measurement, now = self.flight.backend.read(), self.flight.links.clock.now()
        if now - self._taken > LOOK:
            self._taken = now
            self.flight.journal.take(self.flight.backend.epoch)
        return measurement

    def command(self, command: Command) -> None:
        """Send a command to the vehicle, as `VehicleBackend.command` does.

        Args:
            command: Of the mission.
        """
        self.flight.backend.command(command)

    def stop(self) -> None:
        """Fly back, land, and close the links; may be called twice. Ctrl-C on the way lands the vehicle where it is.

        Raises:
            BackendError: if the vehicle did not land, as `end` says, too: it may still be armed.
        """
        self._stopping, self._abort = True, None
        with self._closing:
            if not self.links.is_open:
                return
            try:
                self.flight.backend.stop()
            finally:
                self.end = self.flight.descend()
        if self.end not in (End.LANDED, End.NOT_FLOWN):
            seen = self.flight.seen
            raise BackendError(f"{self.end.value}; {seen}" if seen else self.end.value, field="landing")

    def _new_flight(self) -> GuardedFlight:
        return GuardedFlight(self._model, self.links, self._recorder, self._say or (lambda words: None))

    def _go_through(self, checks: list[Check]) -> None:
        """Tell of the checklist's warnings, and refuse what it is not passed by."""
        say = self._say or logging.getLogger(__name__).warning
        for one in checks:
            if one.verdict is Verdict.WARNING:
                say(f"{one.name}: {one.found} → {one.advice}" if one.advice else f"{one.name}: {one.found}")
        bad = [one for one in checks if one.verdict is Verdict.BAD]
        if bad:
            raise BackendError("; ".join(f"{one.name}: {one.found}" for one in bad), field="checklist")
        if not self._confirm(checks):
            raise BackendError("not confirmed", field="checklist")


@contextmanager
def _ended_by_exceptions(may: Callable[[], bool]) -> Iterator[None]:
    """Let signals that would kill the process raise SystemExit, once and only while they may; two Ctrl-C at once are one."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    stopped, interrupted_at = False, -math.inf

    def end(number: int, _: FrameType | None) -> None:
        nonlocal stopped
        if may() and not stopped:
            stopped = True
            raise SystemExit(128 + number)

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted_at
        before, interrupted_at = interrupted_at, time.monotonic()
        if interrupted_at - before > SAME_INTERRUPT:
            signal.default_int_handler(number, frame)

    handlers: dict[signal.Signals, tuple[Any, Any]] = {
        **dict.fromkeys((signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT), (signal.SIG_DFL, end)),
        **dict.fromkeys(STOPPING, (signal.SIG_DFL, signal.SIG_IGN)),
        signal.SIGINT: (signal.default_int_handler, interrupt),
    }
    taken = {number: own for number, (own, _) in handlers.items() if signal.getsignal(number) is own}
    for number in taken:
        signal.signal(number, handlers[number][1])
    try:
        yield
    finally:
        for number, own in taken.items():
            signal.signal(number, own)
