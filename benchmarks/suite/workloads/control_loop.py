"""Control loop: whole missions against the clock, the controller's ticks while another thread plans; how even are they?

What flies is the mission of `doorman fly`: estimator, state machine, controller and recorder at the controller's rate, and the
planner in its thread at its own. The plant is the simulator, advanced by one period in every `read`, on the controller's time.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import doorman
from doorman.exceptions import DoormanError
from doorman.hardware.interface import Backend, Command, Measurement
from doorman.hardware.scheduling import real_time
from doorman.hardware.vehicle.backend import Ticker
from doorman.mission import Mission
from doorman.recording import Recorder
from doorman.simulation import SimulatedBackend
from suite import standstills
from suite.session import Session
from suite.statistics import quantiles

TICKS = 200.0
"""Of the controller [Hz]."""

PLANS = 100.0
"""Of the planner [Hz]."""

FLIGHTS = ("paper", "push")


LONGEST = 60.0
"""Longest flight; missions end sooner [s]."""


def measure(session: Session, seconds: float) -> dict[str, Any]:
    """Ticks and plans of one mission of either kind of contact.

    Args:
        session: Not used but for its interface: threads go where the system puts them.
        seconds: For which an idle process ticks.
    """
    return {"rows": [_fly(name, LONGEST) for name in FLIGHTS], "nothing": standstills.measure(TICKS, seconds)}


def _fly(name: str, seconds: float) -> dict[str, Any]:
    changed = {"planner.rate": PLANS, "simulation.controller_rate": TICKS}
    model = doorman.Model(doorman.Scenario.load(name, changed))
    planner, recorder = doorman.Planner(model), Recorder(None, {})
    Mission(model, planner).fly(SimulatedBackend(model), 12.0)  # everything is loaded
    backend = _Clocked(SimulatedBackend(model))
    with real_time() as priority:
        try:
            Mission(model, planner, recorder).fly(backend, seconds)
        except DoormanError as error:
            return {"scenario": name, "error": str(error)}
    recording, ticks = recorder.recording(), backend.ticker.statistics()
    plans = recording["plan"]
    periods = np.abs(np.array(backend.ticker.periods) - backend.ticker.period)
    return {
        "scenario": name, "ticks": ticks.ticks, "missed": ticks.missed, "priority": priority,
        "off": quantiles(periods),
        "plans": len(plans.time), "planning": float(np.median(np.diff(plans.time))),
        "solve": {"median": float(np.median(plans["solve_time"])), "max": float(plans["solve_time"].max())},
    }  # fmt: skip


class _Clocked(Backend):
    """A simulated vehicle whose ticks are those of the clock."""

    real_time = True

    def __init__(self, simulated: SimulatedBackend) -> None:
        self._simulated = simulated
        self.ticker = Ticker(simulated.period)

    def open(self) -> None:
        """Build the plant; ticks count from here."""
        self._simulated.open()
        self.ticker = Ticker(self._simulated.period)

    def read(self) -> Measurement:
        """Wait for the tick, and advance the plant by one period."""
        self.ticker.wait()
        return self._simulated.read()

    def command(self, command: Command) -> None:
        """Hand on."""
        self._simulated.command(command)

    def stop(self) -> None:
        """Hand on."""
        self._simulated.stop()
