"""Session: arm, take off, hover, mission, back, land. It has one defined end for whatever happens on the way."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass

from doorman.copying import Uncopied
from doorman.exceptions import DoormanError
from doorman.flight.ends import End
from doorman.flight.guarded import SAME_INTERRUPT, GuardedFlight
from doorman.hardware.safety import Fault, Finding
from doorman.hardware.vehicle import VehicleLinks
from doorman.mission import Mission, OnProgress, Phase
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.recording import Recorder

_SAME_SIGNAL = 1.0
"""Two signals within this are one, as what a process group and a parent both send [s]."""


@dataclass(frozen=True)
class FlightReport:
    """What became of a flight."""

    end: End
    completed: bool
    """Whether the mission flew to its end by itself."""
    message: str
    """Why not."""
    seen: str
    """What the vehicle lay on in the air, or lies on now; empty where it touched nothing that shows, and stands on the floor."""
    findings: tuple[Finding, ...]
    """Findings of the supervisor."""


class FlightSession(Uncopied):
    """One flight of one mission, on links that are open.

    Args:
        model: Model of the scenario.
        links: Of the vehicle, open.
        planner: Of the same scenario, rehearsed.
        recorder: Gets everything; written by the thread that calls `fly`.
        say: Called with every step, one line.
    """

    def __init__(
        self,
        model: Model,
        links: VehicleLinks,
        planner: Planner,
        recorder: Recorder,
        say: Callable[[str], None] = lambda words: None,
    ) -> None:
        self.links = links
        self.flight = GuardedFlight(model, links, recorder, say)
        self.backend, self.supervisor, self.journal = self.flight.backend, self.flight.supervisor, self.flight.journal
        self._recorder = recorder
        self._mission = Mission(model, planner, recorder)
        self._interrupted_at: float | None = None
        self._ending_since: float | None = None
        self._flying_mission = False

    def fly(self, duration: float | None = None, on_progress: OnProgress | None = None) -> FlightReport:
        """Fly, and come down again.

        Args:
            duration: Longest time of the mission [s].
            on_progress: Called by the mission.

        Returns:
            How it ended.
        """
        completed, message = False, ""
        self.flight.begin()
        try:
            message = self.flight.rise()
            if not message:
                self.flight.say("mission")
                self._fly_mission(duration, on_progress)
                message = self._mission.outcome[1]
                completed = self.supervisor.action is None and not message
        except DoormanError as error:
            message = str(error)
        except Exception as error:  # whatever it is, the vehicle comes down, and the report says why
            message = f"{type(error).__name__}: {error}"
            self.flight.say(traceback.format_exc())
        finally:
            end = self.flight.descend()
        reason, seen = self.supervisor.reason, self.flight.seen
        return FlightReport(end, completed, reason or message, seen, tuple(self.supervisor.findings))

    def interrupt(self) -> None:
        """The operator's Ctrl-C: the first one gives the mission up and retreats, the second one lands."""
        now, before = time.monotonic(), self._interrupted_at
        if before is not None and now - before < SAME_INTERRUPT:
            return
        self._interrupted_at = now
        first = before is None and self._flying_mission
        self.supervisor.wish(Fault.OPERATOR_ABORT if first else Fault.OPERATOR_LAND)

    def terminate(self) -> None:
        """The process is to end: fly out of the doorway and land; at a second signal a second later, land where the vehicle is.

        A signal that reaches the process twice at once, by its group and by its parent, is one.
        """
        now = time.monotonic()
        self._ending_since = now if self._ending_since is None else self._ending_since
        again = now - self._ending_since > _SAME_SIGNAL
        self.supervisor.wish(Fault.OPERATOR_LAND if again else Fault.TERMINATED)

    @property
    def phase(self) -> str:
        """Where the mission is."""
        return str(self._mission.phase.value)

    def _fly_mission(self, duration: float | None, on_progress: OnProgress | None) -> None:
        self.supervisor.watch_mission(self._mission.abort)
        self._flying_mission = True
        try:
            self._mission.fly(self.backend, duration, self._with_journal(on_progress))
        finally:
            self._flying_mission = False
            self._recorder.write("epoch", 0.0, {"epoch": self.backend.epoch})
            status = self.links.autopilot.status()  # `doorman merge` puts the autopilot's own log on this clock
            clock = {"autopilot_offset": status.clock_offset, "round_trip": status.round_trip}
            self._recorder.write("clock", 0.0, clock)

    def _with_journal(self, on_progress: OnProgress | None) -> OnProgress:
        patience, last = self._mission.model.scenario.mission.time_out.hold, self._mission.phase

        def progress(now: float, door_angle: float) -> None:
            nonlocal last
            self.journal.take(self.backend.epoch)
            before, last = last, self._mission.phase
            if last is Phase.HOLD and before is not last:
                self.flight.say(
                    f"the door does not stay open by itself: hold it, then press Ctrl-C; the vehicle lets go after {patience:g} s"
                )
            if on_progress is not None:
                on_progress(now, door_angle)

        return progress
