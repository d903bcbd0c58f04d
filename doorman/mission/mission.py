"""The loop that joins estimator, state machine, planner, controller and a backend; it does not know which backend it flies."""

from __future__ import annotations

import gc
import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace

import numpy as np

from doorman.control.estimation.door_locator import DoorLocator, place_of
from doorman.control.estimation.door_watch import DoorWatch
from doorman.control.estimation.estimator import Estimate, Estimator, Tie
from doorman.control.estimation.lift_scale import LiftScale
from doorman.control.held_load import HeldLoad
from doorman.control.position_controller import PositionController, Setpoint, Thrust
from doorman.control.push_limit import force_in_world, limited
from doorman.control.state_converter import StateConverter
from doorman.control.under_way import UnderWay
from doorman.copying import Uncopied
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.exceptions import DoormanError
from doorman.gravity import weight_of
from doorman.hardware.interface import Backend
from doorman.mission.flight_log import FlightLog
from doorman.mission.following import Following
from doorman.mission.phases.phase import MissionPhase, Phase
from doorman.mission.schedule import PlanSchedule
from doorman.mission.sequence import Sequence
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.recording import Recorder
from doorman.signals import Command, Measurement
from doorman.stages import Handover
from doorman.summary import FLOWN

OnProgress = Callable[[float, float], None]
"""Called with the time flown and the door angle, once per planner period."""


class Mission(Uncopied):
    """Opens the door: measure, estimate, decide, plan, control, command, and record all of it.

    Args:
        model: Model of the scenario.
        planner: Planner of the same scenario; made here if not given.
        recorder: Where everything goes; in memory only if not given.
        after: What the step before has left, where the tip holds the handle already.
        phases: Phases of your own, each flown before one of the mission's.
    """

    def __init__(
        self,
        model: Model,
        planner: Planner | None = None,
        recorder: Recorder | None = None,
        after: Handover | None = None,
        *,
        phases: Iterable[type[MissionPhase]] = (),
    ) -> None:
        self.model = model
        self.recorder = recorder or Recorder(None, {})
        self.converter = StateConverter(model)
        settings = model.scenario
        if planner is not None and planner.model.scenario != settings:
            raise DoormanError("the planner was made for another scenario", field="planner")
        latency = settings.simulation.planner_latency_periods
        self._schedule = PlanSchedule(planner or Planner(model), latency, self.recorder)
        self._controller = PositionController(
            model.vehicle.mass, weight_of(1.0), model.vehicle.max_thrust, settings.control, model.actuation
        )
        self._under_way = UnderWay(model.attitude_loop, model.vehicle.mass)
        self._locator, self._watch = DoorLocator(model), DoorWatch(model)
        self._log = FlightLog(model, self.recorder, self._locator, self._watch)
        self._known: Estimate | None = None
        self._estimator = Estimator(model)
        self._sequence = Sequence(
            model, self.converter, self._schedule, self._estimator, self._log.phase, after is not None, phases
        )
        self._sequence.attempt.place = self._locator.known
        self._face_is_known = False
        self._following = Following(self.converter, self._schedule)
        self._flew_plan = self._loop_is_known = False
        self._last_time: float | None = None
        self._last_setpoint: Setpoint | None = None
        self._rotors = np.array([0.0, 0.0, model.vehicle.weight])
        self._lift = LiftScale(model.vehicle.max_thrust)
        self._abort_reason = ""
        self._loop: AttitudeLoop | None = None
        self._rates_late = 0.0
        self._load = HeldLoad(model, after)
        if after is not None:
            self._estimator.go_on(after.tip_force, after.of_the_air)
            self._following.controller.carry(self._load.in_face)
            if after.loop is not None:
                self._know_loop(after.loop, after.rates_late)

    @property
    def handover(self) -> Handover | None:
        """What the next step begins with; None before the first tick."""
        if self._known is None:
            return None
        return Handover(self._load.force, self._estimator.of_the_air, self._loop, self._rates_late)

    @property
    def phase(self) -> Phase:
        """Where the mission is."""
        return self._sequence.phase

    @property
    def outcome(self) -> tuple[bool, str]:
        """Whether the door was brought to the goal and stayed there by the mission's estimate, and what went wrong if not."""
        attempt = self._sequence.attempt
        return attempt.opened, attempt.failure or attempt.seen

    def abort(self, reason: str) -> None:
        """Let go of the door, retreat and hover; from any thread.

        Args:
            reason: Why, for the recording.
        """
        self._abort_reason = reason

    def fly(self, backend: Backend, duration: float | None = None, on_progress: OnProgress | None = None) -> None:
        """Fly to the mission's end, or for a time; the backend is opened here and stopped whatever happens.

        Args:
            backend: What to fly.
            duration: At most so long [s]; to the end if not given: every phase has a time-out.
            on_progress: Called once per planner period.

        Raises:
            DoormanError: if the backend or an input fails, or this mission has flown before. What was recorded is kept.
        """
        if self._last_time is not None:
            raise DoormanError("a mission flies once; make another one", field="mission")
        self._log.begin()
        now, next_report = 0.0, 0.0
        end = math.inf if duration is None else duration - 1e-9
        outcome = FLOWN
        self._sequence.attempt.comes_back = backend.comes_back
        backend.watch_mission(self.abort)
        try:
            with self._schedule.running(backend.real_time), backend, _no_garbage_collection(backend.real_time):
                self._log.begin()
                while now < end and self.phase is not Phase.DONE:
                    measurement = backend.read()
                    now = measurement.time
                    angle = self._tick(backend, measurement)
                    if on_progress is not None and now >= next_report:
                        next_report = now + self._schedule.period
                        on_progress(now, angle)
                attempt = self._sequence.attempt
                outcome = attempt.failure or ", ".join(filter(None, (FLOWN, attempt.seen)))
        except (KeyboardInterrupt, SystemExit):
            outcome = "interrupted"
            raise
        except Exception as error:
            outcome = f"failed: {error}"
            raise
        finally:
            self._log.phase(now, "end", outcome)

    def _tick(self, backend: Backend, measured: Measurement) -> float:
        """One period of the controller; returns the estimated door angle.

        All of it sees the door where the map has it: `DoorLocator` moves measurements and commands.
        """
        self._see_frame(measured)
        self._learn_frame()
        tie = self._sequence.tie
        leaf, measured = measured.leaf, self._watch.checked(measured, self._known, tie)
        now, measurement = measured.time, self._locator.seen(measured)
        elapsed = 0.0 if self._last_time is None else now - self._last_time
        self._last_time = now
        estimate = self._estimator.update(measurement, tie, self._sequence.closes_gripper, elapsed)
        seen = estimate.attitude
        if estimate.lost:
            self.abort("the estimate was lost")
        self._known = estimate
        if self._abort_reason:
            self._sequence.abort(estimate, self._abort_reason)
        if self.phase is Phase.HOVER:
            self._sequence.attempt.poses.note(measured)
        setpoint, phase = self._sequence.step(estimate, measurement.body_rates, elapsed)
        self._learn_loop(now, backend)
        tie = phase.tie
        if self._load.note(estimate, tie is Tie.GRIPPED, elapsed):
            self._controller.resume(estimate.position, estimate.velocity, estimate.wind)
        planned = self._following.follow(estimate, measurement, phase.follows, phase.goal, elapsed)
        if isinstance(planned, Command):
            command = planned
            thrust = Thrust(planned.thrust, planned.attitude, force_in_world(planned), estimate.wind, False)
        else:
            setpoint = planned or setpoint
            thrust, command = self._fly_to(setpoint, estimate, measurement.body_rates, tie, elapsed)
        command, self._flew_plan = command.gripping(phase.tied), isinstance(planned, Command)
        if phase.at_the_leaf:
            command = limited(command, self.model.vehicle.weight, self.model.scenario.control.max_push)
        if tie is not Tie.GRIPPED:
            self._lift.learn(estimate.lift)
        scaled = self._lift.scaled(command)
        force = scaled.body_force
        self._rotors = self._lift.scale * force
        self._under_way.note(now, scaled.attitude)
        if (test := self._sequence.attempt.loop_test).runs:
            test.note(scaled.attitude, seen, measurement)
        self._following.controller.note(now, command, float(measurement.attitude[2]))
        sent = self._locator.in_world(scaled)
        backend.command(sent)
        self._estimator.note_force(force)
        self._log.tick(measured, estimate, setpoint, thrust, sent)
        self._log.door(measured, leaf)
        self._locator.update(measured, phase.at_the_leaf and estimate.touching, tie is Tie.GRIPPED, elapsed)
        return estimate.door_angle

    def _fly_to(
        self, setpoint: Setpoint, estimate: Estimate, body_rates: np.ndarray, tie: Tie, elapsed: float
    ) -> tuple[Thrust, Command]:
        """Without a plan: the position controller."""
        controller, seen = self._controller, estimate.attitude
        if self._flew_plan:
            controller.resume(estimate.position, estimate.velocity, self._load.outer(estimate))
        self._change_smoothly(setpoint, estimate)
        controller.reach = min(self._lift.scale, 1.0)
        later = None
        if tie is not Tie.GRIPPED:
            outer = controller.observer.estimate - setpoint.force
            later = self._under_way.later(estimate.time, seen, body_rates, estimate.velocity, self._rotors, outer)
        force = estimate.rotation_body_to_world @ self._rotors
        thrust = controller.update(estimate.position, estimate.velocity, setpoint, elapsed, later, force)
        attitude = thrust.attitude if setpoint.nudge is None else thrust.attitude + np.array([*setpoint.nudge, 0.0])
        ahead, left, up = self.model.actuation.body_force(thrust.force, seen)
        return thrust, Command(float(up), attitude, setpoint.arm_rates, False, (float(ahead), float(left)))

    def _see_frame(self, measured: Measurement) -> None:
        """A sensor of the door's frame says where that stands."""
        frame = measured.frame
        found = self._watch.moves(frame)
        if self._watch.refused and not self._abort_reason:
            self.abort(self._watch.refused)
        if found is not None and frame is not None:
            self._locator.measure(*found, frame.position_deviation, frame.yaw_deviation)

    def _learn_frame(self) -> None:
        """Once the frame has been touched, or seen by a sensor, the door stands where that is, if that says more than the map."""
        place, model = self._sequence.attempt.place, self.model
        if self._face_is_known or not place.found:
            return
        self._face_is_known = True
        at = model.coupling.contact_point(model.start_angle) - model.door.hinge_position
        normal = model.door.normal(model.start_angle)
        if place.deviation(at, normal) < 0.5 * place_of(model).deviation(at, normal):
            self._estimator.know_the_face()

    def _learn_loop(self, now: float, backend: Backend) -> None:
        """Once the attitude loop has been measured, this flight's plans and controllers count on what was found."""
        test = self._sequence.attempt.loop_test
        found = test.measured
        if found is None or self._loop_is_known or test.unfit():
            return
        self._know_loop(replace(found.loop, feedback=backend.feedback_lag), test.rates_late)
        self.recorder.write("attitude_loop", now, {**asdict(found), "rates_late": test.rates_late})

    def _know_loop(self, loop: AttitudeLoop, rates_late: float) -> None:
        self._loop_is_known, self._loop, self._rates_late = True, loop, rates_late
        self._estimator.rates_are_late(rates_late)
        for user in (self.converter, self._under_way, self._following.controller):
            user.fly_by(loop)

    def _change_smoothly(self, setpoint: Setpoint, estimate: Estimate) -> None:
        """From force back to position control: the observer begins with the wind, not with what it took the door for."""
        last, self._last_setpoint = self._last_setpoint, setpoint
        if last is not None and last.push is not None and setpoint.push is None:
            self._controller.observer.align(last.normal, estimate.wind, estimate.velocity)


@contextmanager
def _no_garbage_collection(first: bool) -> Iterator[None]:
    """No collection in flight: it would stop the controller for milliseconds; reference counts free what a tick makes."""
    enabled = gc.isenabled()
    if first:
        gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
