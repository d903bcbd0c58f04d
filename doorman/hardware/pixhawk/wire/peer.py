"""Where the autopilot speaks from, and whether another sender may take its place.

A link without signatures carries whatever somebody sends. A datagram from another address may come from the autopilot, behind a
router that has started anew, or from anybody. On the ground the place may change, and that is reported. While the vehicle is
armed it is reported and refused.
"""

from __future__ import annotations

from doorman.hardware.pixhawk.events import EventKind, LinkLog
from doorman.hardware.pixhawk.wire.transport import Address, Line

SILENCE = 3.0
"""After which the autopilot may speak from another address [s]."""
_REPORT_PERIOD = 1.0
"""Between two reports of the same sender [s]."""
_MOST_REPORTS = 20
"""In that time: a flood of senders does not fill the log."""
_TAKEN = "taken after silence"


class PeerKeeper:
    """Keeps the address that the autopilot speaks from; used by the thread of the link only."""

    def __init__(self, events: LinkLog, signed: bool) -> None:
        self.address: Address = None
        """Where the autopilot speaks from; None until it is heard, and on a line with one sender."""
        self._events, self._signed = events, signed
        self._reported: dict[object, float] = {}

    def heard_at(self, address: Address, line: Line, silent: float, armed: bool, now: float) -> None:
        """Take in that a heartbeat with the autopilot's ids came from an address."""
        if address is None or address == line.peer:
            return
        if line.peer is None or silent == float("inf"):
            line.peer = self.address = address
        elif armed and not self._signed:
            self._report("refused while armed", address, line.peer, now)
        elif silent <= SILENCE:
            self._report("ignored while the autopilot is heard", address, line.peer, now)
        else:
            self._report(_TAKEN, address, line.peer, now)
            line.peer = self.address = address

    def elsewhere(self, address: Address, line: Line, armed: bool, now: float) -> None:
        """Take in that another message with the autopilot's ids came from an address that is not its: it is ignored."""
        if address is not None and line.peer is not None and address != line.peer:
            what = "refused while armed" if armed and not self._signed else "ignored until a heartbeat comes from there"
            self._report(what, address, line.peer, now)

    def another(self, sender: tuple[int, int], identity: tuple[int, int], now: float) -> None:
        """Take in that another autopilot's heartbeat came from where ours speaks: it is never obeyed."""
        self._note(
            sender, f"refused: system {sender[0]}, component {sender[1]} sends from the address of system {identity[0]}", now,
            system=sender[0], component=sender[1], taken=False,
        )  # fmt: skip

    def _report(self, what: str, address: tuple[str, int], before: tuple[str, int], now: float) -> None:
        words = f"the autopilot's ids come from {address[0]}:{address[1]} instead of {before[0]}:{before[1]}: {what}"
        self._note((address, what), words, now, address=address, taken=what is _TAKEN)

    def _note(self, what: object, words: str, now: float, **values: object) -> None:
        self._reported = {key: time for key, time in self._reported.items() if now - time < _REPORT_PERIOD}
        if what not in self._reported and len(self._reported) < _MOST_REPORTS:
            self._reported[what] = now
            self._events.happen(EventKind.PEER_CHANGED, now, words, **values)
