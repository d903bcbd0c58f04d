"""COMMAND_LONG with its acknowledgement: sent again while no answer comes, waited for while it is in progress."""

from __future__ import annotations

from collections.abc import Callable

from doorman.hardware.pixhawk.events import EventKind, Outcome, OutcomeStatus
from doorman.hardware.pixhawk.link.exchange import Acknowledgement
from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.wire.messages import command_message, mavlink

_TRIES = 5
_TEXT_WAIT = 0.3
"""For the autopilot's reasons, which it sends after its refusal, if at all [s]."""
_LONGEST_PROGRESS = 30.0
_RESULTS = {
    mavlink.MAV_RESULT_TEMPORARILY_REJECTED: "temporarily rejected",
    mavlink.MAV_RESULT_DENIED: "denied",
    mavlink.MAV_RESULT_UNSUPPORTED: "unsupported",
    mavlink.MAV_RESULT_FAILED: "failed",
    6: "cancelled",
}


def command(
    link: Link, number: int, *parameters: float, tries: int = _TRIES, go_on: Callable[[], bool] = lambda: True
) -> Outcome:
    started = link.time.now()
    start = link.exchange.count
    for confirmation in range(tries):
        link.send(command_message(link.target, number, *parameters, confirmation=confirmation))
        answer = _wait(link, number, start, link.config.timeouts.answer)
        if answer is not None:
            return _outcome(link, number, answer, started)
        if not (link.alive and go_on()):
            break
    text = f"command {number} was not acknowledged, sent {confirmation + 1} times"
    link.events.happen(EventKind.COMMAND_UNANSWERED, link.time.now(), text, command=number)
    return Outcome(OutcomeStatus.TIMED_OUT, text)


def _wait(link: Link, number: int, start: int, timeout: float) -> Acknowledgement | None:
    """Final acknowledgement of a command; those that say "in progress" prolong the wait."""
    deadline = link.time.now() + _LONGEST_PROGRESS
    while True:
        after = start
        answer = link.exchange.wait(lambda after=after: link.exchange.acknowledgement(number, after), timeout)  # type: ignore[misc]
        if answer is None or answer.result != mavlink.MAV_RESULT_IN_PROGRESS or link.time.now() > deadline:
            return answer
        start = answer.number
        timeout = max(timeout, 2.0)


def _outcome(link: Link, number: int, answer: Acknowledgement, started: float) -> Outcome:
    if answer.result == mavlink.MAV_RESULT_ACCEPTED:
        return Outcome(OutcomeStatus.DONE)
    link.exchange.wait(lambda: True if link.exchange.texts(started) else None, _TEXT_WAIT)
    texts = "; ".join(link.exchange.texts(started))
    words = _RESULTS.get(answer.result, f"result {answer.result}")
    text = f"command {number} {words}" + (f": {texts}" if texts else "")
    link.events.happen(EventKind.COMMAND_REFUSED, link.time.now(), text, command=number, result=answer.result)
    return Outcome(OutcomeStatus.REFUSED, text)
