"""Before the motors may run: the gripper is tried, as in the air it must open whatever has failed, and the autopilot engaged."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from doorman.clocks import LOOK
from doorman.hardware.pixhawk import Outcome, OutcomeStatus
from doorman.hardware.vehicle import VehicleLinks
from doorman.hardware.vehicle.gripper import CLOSED, CLOSES_WITHIN, HALF_OPEN, OPENS_WITHIN
from doorman.hardware.vehicle.waiting import SETTLING


def try_gripper(links: VehicleLinks, say: Callable[[str], None]) -> str:
    """Close it, and let its spring open it. Returns what went wrong."""
    if not links.config.gripper:
        return ""
    say("try the gripper: close it, then let its spring open it")
    servos, rest = links.servos, np.zeros(links.config.n_arm)

    def moves(patience: float, there: Callable[[float], bool], act: Callable[[], object]) -> float | None:
        """The angle at which it stays on its way, or None."""
        deadline = links.clock.now() + patience
        while not there(angle := float(servos.read().angles[-1])):
            if links.clock.now() > deadline:
                return angle
            act()
            links.clock.sleep(LOOK)
        return None

    stuck = moves(CLOSES_WITHIN, lambda angle: angle >= CLOSED, lambda: links.move_arm(rest, closed=True))
    if stuck is not None:
        return f"it does not close within {CLOSES_WITHIN:g} s; it has reached {stuck:.2f} of {CLOSED:g} rad"
    stuck = moves(OPENS_WITHIN, lambda angle: angle <= HALF_OPEN, lambda: servos.command(rest, 0.0))
    links.let_go()
    if stuck is not None:
        return f"its spring opens it only to {stuck:.2f} rad, not to {HALF_OPEN:g} rad; fit a stronger spring"
    return ""


def engage(links: VehicleLinks, stops: Callable[[], bool]) -> Outcome:
    """Engage; links that were starved while the program made ready have a moment to become fresh again."""
    begin = links.clock.now()
    while True:
        outcome = links.autopilot.engage(unarmed=True)
        starved = outcome.status is OutcomeStatus.NOT_READY and links.clock.now() - begin < SETTLING
        if not starved or stops():
            return outcome
        links.clock.sleep(LOOK)
