"""Waiting for links that were just opened: until the autopilot has a position, and rates and clocks have been measured."""

from __future__ import annotations

import time

from doorman.hardware.pixhawk import SampleStatus
from doorman.hardware.vehicle.links import VehicleLinks

PATIENCE = 30.0
"""For the autopilot's estimator, longest [s]."""
SETTLING = 2.0
"""For rates and clocks [s]."""


def await_links(links: VehicleLinks) -> None:
    """Wait; what is missing after that, a checklist says.

    Args:
        links: Open.
    """
    deadline = time.monotonic() + PATIENCE
    while links.autopilot.state().status is not SampleStatus.FRESH and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(SETTLING)
