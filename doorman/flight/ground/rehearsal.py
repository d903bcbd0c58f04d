"""Rehearsal on the ground: everything that flies is run once, so that nothing is compiled or loaded in the air."""

from __future__ import annotations

import contextlib

import numpy as np

from doorman.exceptions import DoormanError
from doorman.hardware.interface import Backend, Command, Measurement
from doorman.hardware.vehicle import VehicleConfig
from doorman.mission import Mission
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.recording import Recorder

_TICKS = 20


class _Standstill(Backend):
    """A vehicle that stays at the start whatever the command, in no time."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._ticks = 0

    def open(self) -> None:
        """Nothing to open."""

    def read(self) -> Measurement:
        """The start, a period later every time."""
        self._ticks += 1
        model = self._model
        n, state = model.n_arm, model.start_state
        place = model.coupling.vehicle_motion(state, np.zeros(3), np.zeros(n)).position
        now = (self._ticks - 1) / VehicleConfig.rate
        return Measurement(
            now, place, np.zeros(3), state[:3].copy(), np.zeros(3), state[5:].copy(), np.zeros(n), pose_time=now
        )

    def command(self, command: Command) -> None:
        """Nothing obeys."""

    def stop(self) -> None:
        """Nothing to stop."""


def rehearse(model: Model, planner: Planner) -> None:
    """Plan, replan and control once, at hover and with the tip on the leaf, on the ground and on memory that no flight uses.

    Args:
        model: Model of the scenario.
        planner: That will be flown; what it remembers of the rehearsal is overwritten by its first plan.
    """
    planner.replan(planner.plan(planner.planning.start_state).states[1])
    for start in ("hover", "contact"):
        scenario = model.scenario
        scenario = scenario.model_copy(update={"mission": scenario.mission.model_copy(update={"start": start})})
        rehearsed = Model(scenario)
        with contextlib.suppress(DoormanError):  # a vehicle that does not move is no good pupil
            Mission(rehearsed, recorder=Recorder(None, {})).fly(_Standstill(rehearsed), _TICKS / VehicleConfig.rate)
