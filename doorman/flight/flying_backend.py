"""The vehicle as a backend that takes off when it is opened and lands when it is stopped, under supervision all the time."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import Any

from doorman.exceptions import BackendError
from doorman.feasibility import check
from doorman.flight.checklist import Verdict, preflight
from doorman.flight.guarded import SAME_INTERRUPT, STOPPING, GuardedFlight
from doorman.flight.rehearsal import rehearse
from doorman.hardware.interface import Backend, Command, Measurement
from doorman.hardware.safety import Fault
from doorman.hardware.scheduling import real_time
from doorman.hardware.vehicle import VehicleLinks, vehicle_config
from doorman.hardware.vehicle.waiting import await_links
from doorman.model import Model
from doorman.ocp.planner import Planner
from doorman.recording import Recorder


class FlyingBackend(Backend):
    """Everything that `doorman fly` does around a mission, for programs that fly one by themselves.

    From `open` to `stop`, SIGTERM and SIGHUP raise SystemExit in a program that has no handlers of its own for them, as Ctrl-C
    raises KeyboardInterrupt: where either reaches `stop`, as a mission's does, the vehicle flies back first.

    Args:
        model: Model of the scenario.
        pixhawk: Connection to the autopilot, such as `udp:14540`.
        servos: Serial device of the arm.
        mocap: Where the cameras' stream is received, such as `udp:51001`; None flies on the autopilot's own estimate.
        recorder: Gets what the links and the supervisor tell.
        **settings: Further ones of `vehicle_config`, such as `directions` and `zero_positions` of the servos.
    """

    real_time = True

    def __init__(
        self,
        model: Model,
        pixhawk: str,
        servos: str,
        mocap: str | None = None,
        *,
        recorder: Recorder | None = None,
        **settings: Any,
    ) -> None:
        self._model = model
        self.links = VehicleLinks(vehicle_config(model, pixhawk, servos, mocap, on_mocap_loss="report", **settings))
        self._closing, self._stopping = ExitStack(), False
        self.flight = GuardedFlight(model, self.links, recorder or Recorder(None, {}))

    def open(self) -> None:
        """Open the links, go through the checklist, arm, take off and fly to the hover point.

        Raises:
            BackendError: if a link cannot be opened, the checklist is not passed, or the vehicle does not get to the hover
                point; it is on the ground then.
        """
        findings = check(self._model.scenario)
        rehearse(self._model, Planner(self._model))  # nothing is compiled in the air
        try:
            self._stopping = False
            self._closing.enter_context(_ended_by_exceptions(lambda: not self._stopping))
            self._closing.enter_context(real_time())
            self._closing.callback(self.links.stop)
            self.links.open()
            await_links(self.links)
            bad = [one for one in preflight(self._model, self.links, findings) if one.verdict is Verdict.BAD]
            if bad:
                raise BackendError("; ".join(f"{one.name}: {one.found}" for one in bad), field="checklist")
            self.flight.begin()
            reason = self.flight.rise()
            if reason:
                raise BackendError(reason, field="take-off")
            self.flight.backend.open()
        except BaseException as error:
            if self.flight.supervisor.rising and not isinstance(error, Exception):
                self.flight.supervisor.report(Fault.OPERATOR_LAND)  # its way has not begun
            self.stop()
            raise

    def read(self) -> Measurement:
        """As `VehicleBackend.read`."""
        return self.flight.backend.read()

    def command(self, command: Command) -> None:
        """As `VehicleBackend.command`."""
        self.flight.backend.command(command)

    def stop(self) -> None:
        """Fly back, land, and close the links; may be called twice. Ctrl-C on the way lands the vehicle where it is."""
        self._stopping = True
        with self._closing:
            if self.links.is_open:
                try:
                    self.flight.backend.stop()
                finally:
                    self.flight.descend()


@contextmanager
def _ended_by_exceptions(may: Callable[[], bool]) -> Iterator[None]:
    """Let signals that would kill the process raise SystemExit, once and only while they may; two Ctrl-C at once are one.

    Those that would stop it are ignored.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked, interrupted_at = False, -math.inf

    def end(number: int, _: FrameType | None) -> None:
        nonlocal asked
        if may() and not asked:
            asked = True
            raise SystemExit(128 + number)

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted_at
        before, interrupted_at = interrupted_at, time.monotonic()
        if interrupted_at - before > SAME_INTERRUPT:
            signal.default_int_handler(number, frame)

    taken: dict[signal.Signals, Any] = {}
    handlers: tuple[tuple[signal.Signals, Any, Any], ...] = (
        (signal.SIGTERM, signal.SIG_DFL, end),
        (signal.SIGHUP, signal.SIG_DFL, end),
        (signal.SIGQUIT, signal.SIG_DFL, end),
        *((stopping, signal.SIG_DFL, signal.SIG_IGN) for stopping in STOPPING),
        (signal.SIGINT, signal.default_int_handler, interrupt),
    )
    for number, own, handler in handlers:
        if signal.getsignal(number) is own:
            taken[number] = own
            signal.signal(number, handler)
    try:
        yield
    finally:
        for number, own in taken.items():
            signal.signal(number, own)
