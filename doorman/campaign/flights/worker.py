"""What a worker of the cluster does: each of its threads flies in a flight process of its own."""

from __future__ import annotations

import threading
from typing import Any

from distributed import get_worker

from doorman.campaign.flights.flight_process import FlightProcesses
from doorman.campaign.flights.lease import Lease

_processes: dict[str, FlightProcesses] = {}
"""Flight processes of this process, by campaign."""
_leases: dict[str, Lease] = {}
"""Leases of this process, by campaign."""
_lock = threading.Lock()


def fly(order: dict[str, Any], files: dict[str, str], time_out: float, campaign: str, lease: str) -> dict[str, Any]:
    """Fly one run in the process that belongs to this thread of a worker."""
    with _lock:
        processes = _processes.setdefault(campaign, FlightProcesses())
        if campaign not in _leases:
            _leases[campaign] = Lease(get_worker(), lease, lambda: close_processes(campaign))
    return processes.mine().fly(order, files, time_out)


def close_processes(campaign: str) -> None:
    """Let the flight processes of a campaign go, on this worker."""
    with _lock:
        processes, watched = _processes.pop(campaign, None), _leases.pop(campaign, None)
    if watched is not None:
        watched.end()
    if processes is not None:
        processes.close()
