"""Scheduling: threads that must answer within milliseconds go before ordinary processes, where the system permits it."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from doorman.clocks import BRIEFLY

PRIORITY = 20
"""Priority in the real-time class, 1 … 99: above ordinary processes, below the kernel's own threads."""
_BEHIND = 5
"""Priority difference of a thread that gives way."""
SWITCH_INTERVAL = BRIEFLY / 2
"""Longest turn of a Python thread while another waits; the default of 5 ms is a whole tick [s]."""


@contextmanager
def real_time() -> Iterator[bool]:
    """Round-robin real-time scheduling of this thread and those that it starts meanwhile, and quick hand-overs among them."""
    # What exists by now is taken out of the garbage collector's sight: a collection of it would stop every thread for 0.2 s.
    # Enter when everything is compiled, before links are opened.
    interval = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.collect()
    gc.freeze()
    before = _schedule(getattr(os, "SCHED_RR", 0), PRIORITY)
    try:
        yield before is not None
    finally:
        if before is not None:
            _schedule(*before)
        gc.unfreeze()
        sys.setswitchinterval(interval)


def give_way() -> None:
    """Let this thread go after the others of the real-time class, if it is in that; a planner never delays a controller so."""
    if is_real_time():
        policy, priority = os.sched_getscheduler(0), os.sched_getparam(0).sched_priority
        _schedule(policy, max(priority - _BEHIND, 1))


def _schedule(policy: int, priority: int) -> tuple[int, int] | None:
    """Schedule this thread; returns policy and priority from before, None if that is not permitted."""
    if not hasattr(os, "sched_setscheduler"):
        return None
    before = os.sched_getscheduler(0), os.sched_getparam(0).sched_priority
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except OSError:
        return None
    return before


def is_real_time() -> bool:
    return hasattr(os, "sched_getscheduler") and os.sched_getscheduler(0) in (os.SCHED_RR, os.SCHED_FIFO)
