"""Journal: events of the links and findings of the supervisor during a flight, in the recording, in words."""

from __future__ import annotations

from doorman.hardware.safety import Supervisor
from doorman.hardware.vehicle import VehicleLinks
from doorman.recording import Recorder


class Journal:
    """Takes the links' events and writes them as topic `event`, stamped on the backend's clock."""

    def __init__(self, links: VehicleLinks, supervisor: Supervisor, recorder: Recorder) -> None:
        self._links, self._supervisor, self._recorder = links, supervisor, recorder
        self._findings = 0
        self.lines: list[str] = []  # everything so far, in words

    def take(self, epoch: float) -> None:
        """Write what has happened since the last call."""
        events = [(event.time, "pixhawk", event.message) for event in self._links.autopilot.events()]
        events += [(event.time, "servos", str(event)) for event in self._links.servos.events()]
        if self._links.mocap is not None:
            events += [(event.time, "mocap", str(event)) for event in self._links.mocap.events()]
        if self._links.tip_force is not None:
            events += [(time, "tip_force", words) for time, words in self._links.tip_force.events()]
        if self._links.door is not None:
            events += [(time, "door_sensor", words) for time, words in self._links.door.events()]
        new = self._supervisor.findings[self._findings :]
        self._findings += len(new)
        events += [(finding.time, "safety", str(finding)) for finding in new]
        for time, source, words in sorted(events):
            since = max(time - epoch, 0.0) if epoch == epoch else 0.0
            self._recorder.write("event", since, {"source": source, "message": words})
            self.lines.append(f"{since:7.3f} s {source}: {words}")
        if events:
            self._recorder.flush()  # it may be what explains a fall
