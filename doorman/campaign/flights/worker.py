"""What a worker of the cluster does: each of its threads flies in a flight process of its own."""

from __future__ import annotations

import threading
from typing import Any

from distributed import get_worker

from doorman.campaign.flights.flight_process import FlightProcess
from doorman.campaign.flights.lease import Lease

_processes: dict[tuple[str, int], FlightProcess] = {}
"""Flight processes of this process, by campaign and thread."""
_leases: dict[str, Lease] = {}
"""Leases of this process, by campaign."""
_processes_lock = threading.Lock()


def fly(order: dict[str, Any], files: dict[str, str], time_out: float, campaign: str, lease: str) -> dict[str, Any]:
    """Fly one run in the process that belongs to this thread of a worker."""
    with _processes_lock:
        flight_process = _processes.setdefault((campaign, threading.get_ident()), FlightProcess())
        if campaign not in _leases:
            _leases[campaign] = Lease(get_worker(), lease, lambda: close_processes(campaign))
    return flight_process.fly(order, files, time_out)


def close_processes(campaign: str) -> None:
    """Let the flight processes of a campaign go, on this worker."""
    with _processes_lock:
        processes = [_processes.pop(key) for key in list(_processes) if key[0] == campaign]
        watched = _leases.pop(campaign, None)
    if watched is not None:
        watched.end()
    for flight_process in processes:
        flight_process.close()
