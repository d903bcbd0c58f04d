"""A mission whose tip is at the leaf by the whole-body plan: the rest, and all decisions, are `doorman.mission`'s."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from doorman.control.estimator import Estimate
from doorman.control.position_controller import Thrust
from doorman.hardware.interface import Backend
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.mission.mission import Mission
from doorman.mission.phases import Phase
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.recording import Recorder
from doorman.signals import Command, Measurement
from doorman.simulation import SimulatedBackend
from doorman.summary import summarize
from suite.whole_body.belief import Belief, Known
from suite.whole_body.pilot import Pilot

_AT_THE_LEAF = (Phase.TOUCH, Phase.OPEN, Phase.RECOVER, Phase.HOLD)


class WholeBodyMission(Mission):
    """Touch, swing, loss of contact and hold are one problem; before and after them the position controller flies.

    Args:
        model: Model of the scenario.
        planner: Of the push, for what the phases decide.
        recorder: Where everything goes.
    """

    def __init__(self, model: Model, planner: Planner | None, recorder: Recorder) -> None:
        super().__init__(model, planner, recorder)
        self.belief, self.pilot = Belief(model, self.converter), Pilot(model)

    def _tick(self, backend: Backend, measurement: Measurement) -> float:
        """One period: as in every mission, but the command at the leaf is the whole-body plan's."""
        now = measurement.time
        elapsed = 0.0 if self._last_time is None else now - self._last_time
        self._last_time = now
        force = self._thrust * rotation_body_to_world(measurement.attitude)[:, 2]
        estimate = self._estimator.update(measurement, force, self._sequence.tie, elapsed)
        if self._abort_reason:
            self._sequence.abort(estimate, self._abort_reason)
        seeks = self.phase in _AT_THE_LEAF or self.phase is Phase.RELEASE
        known = self.belief.update(measurement, force, elapsed, seeks, self.pilot.opening_rate)
        estimate = self._at_the_leaf(estimate, known) if seeks else replace(estimate, wind=known.wind)
        if self.phase in _AT_THE_LEAF and self._sequence._push is not None:
            self._sequence._push.push = known.normal_force  # a release begins with what the tip pushes with
        action = self._sequence.step(estimate, measurement.body_rates, elapsed)
        setpoint = action.setpoint
        self._change_smoothly(setpoint, estimate)
        thrust = self._controller.update(estimate.position, estimate.velocity, setpoint, elapsed)
        if self.phase in _AT_THE_LEAF:
            command = self.pilot.command(now, known, elapsed, float(measurement.attitude[2]))
            thrust = Thrust(command.thrust, command.attitude, thrust.force, thrust.disturbance, thrust.saturated)
        else:
            self.pilot.forget()
            command = Command(thrust.thrust, thrust.attitude, setpoint.arm_rates, action.grip)
        self._thrust = command.thrust
        backend.command(command)
        self._estimator.tell(command.attitude)
        self._record(measurement, estimate, setpoint, thrust, command)
        return estimate.door_angle

    @staticmethod
    def _at_the_leaf(estimate: Estimate, known: Known) -> Estimate:
        """What the phases decide by while the tip is at the leaf."""
        state = estimate.state.copy()
        state[3:5] = known.door_angle, known.door_rate
        turned = math.asin(known.face_offset / known.lever)
        return replace(
            estimate, state=state, wind=known.wind, touching=known.touching, normal_force=known.normal_pull,
            tip_force=estimate.tip_force + known.wind - estimate.wind, tip_angle=estimate.tip_angle - turned,
        )  # fmt: skip


def fly(model: Model, seed: int, planner: Planner | None = None) -> dict[str, Any]:
    """Fly one scenario in simulation.

    Args:
        model: Model of the scenario.
        seed: Of noise and gusts.
        planner: Of the push, to save its construction.

    Returns:
        The summary; also `whole_body_ms`, which plans took at 50 and 99 per cent and at most, and how many `diverged`.
    """
    with Recorder(None, {}) as recorder:
        mission = WholeBodyMission(model, planner, recorder)
        mission.fly(SimulatedBackend(model, seed=seed, recorder=recorder))
        summary: dict[str, Any] = summarize(recorder.recording(), model)
    times = 1e3 * np.array(mission.pilot.solve_times or [0.0])
    return summary | {
        "whole_body_ms": [float(value) for value in np.percentile(times, [50.0, 99.0, 100.0])],
        "diverged": mission.pilot.rejected,
    }
