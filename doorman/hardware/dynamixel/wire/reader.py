"""Reading all servos: one sync read, with ways around a servo that does not answer."""

from __future__ import annotations

from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.wire.link import Link, Outcome, Reply
from doorman.hardware.dynamixel.wire.registers import INDIRECT_DATA
from doorman.hardware.dynamixel.wire.telemetry import BLOCK_SIZE

PROBE_INTERVAL = 0.05
"""How often a missing servo is looked for [s]."""


class ServoReader:
    """Reads the telemetry block of every servo."""

    # In a sync read every servo waits for its predecessor's answer, so one silent servo silences those after it: they are asked
    # one by one, and a servo that stays silent is left out and only looked for now and then.

    def __init__(self, link: Link, config: ServoConfig) -> None:
        self._link = link
        self._ids = config.ids
        self._next_probe = 0.0
        self.absent: set[int] = set()  # joints that are left out of the sync read and looked for
        self.excluded: int | None = None  # joint that is left alone altogether while it is being recovered

    def read(self) -> dict[int, Reply]:
        """Ask every servo."""
        present = [joint for joint in range(len(self._ids)) if joint not in self.absent and joint != self.excluded]
        replies: dict[int, Reply] = {}
        if present:
            answers = self._link.sync_read([self._ids[joint] for joint in present], INDIRECT_DATA, BLOCK_SIZE)
            replies = dict(zip(present, answers, strict=True))
            silent = [joint for joint in present if replies[joint].outcome in (Outcome.TIMEOUT, Outcome.CORRUPT)]
            for joint in silent[1:]:
                replies[joint] = self._read_one(joint)
        return replies | self._probe()

    def _probe(self) -> dict[int, Reply]:
        wanted = sorted(self.absent - {self.excluded})
        if not wanted or self._link.now() < self._next_probe:
            return {}
        joint = wanted[int(self._next_probe / PROBE_INTERVAL) % len(wanted)]
        self._next_probe = self._link.now() + PROBE_INTERVAL
        return {joint: self._read_one(joint)}

    def _read_one(self, joint: int) -> Reply:
        return self._link.read(self._ids[joint], INDIRECT_DATA, BLOCK_SIZE)
