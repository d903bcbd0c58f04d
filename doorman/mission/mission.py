"""The loop that joins planner, controller and a backend; it does not know which backend it flies."""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from doorman.control.door_observer import DoorObserver
from doorman.control.position_controller import PositionController, Setpoint, Thrust
from doorman.control.state_converter import StateConverter
from doorman.exceptions import DoormanError
from doorman.hardware.interface import Backend, Command, Measurement
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import GRAVITY, Model
from doorman.ocp.planner import Plan, Planner
from doorman.ocp.planning_model import planning_model
from doorman.recording import Recorder, Recording
from doorman.scenario import Scenario
from doorman.summary import summarize

OnProgress = Callable[[float, float], None]
"""Called with the time flown and the door angle, once per planner period."""


@dataclass(frozen=True)
class TimedPlan:
    """A plan with the time of the state it starts from, and the time from which it may be used."""

    plan: Plan
    start: float
    available_at: float


@dataclass
class PlanSchedule:
    """Plans once per period; hands out the newest one that is old enough to be known.

    Args:
        planner: The planner.
        latency_periods: Periods between the measurement of a state and the use of its plan.
        recorder: Where every plan goes.
    """

    planner: Planner
    latency_periods: int
    recorder: Recorder
    _waiting: list[TimedPlan] = field(default_factory=list)
    current: TimedPlan | None = None
    """What `update` returned last."""
    _next: float = 0.0
    _started: bool = False

    def __post_init__(self) -> None:
        self._planning = planning_model(self.planner.model)

    @property
    def period(self) -> float:
        """Between plans [s]."""
        return 1.0 / self.planner.settings.rate

    def update(self, now: float, state: np.ndarray, door_disturbance: float) -> TimedPlan | None:
        """Plan if it is time to, and return the plan to follow now.

        A plan that is not flyable is recorded and dropped: the last usable one is followed to its end, where it rests.

        Args:
            now: Time of the state [s].
            state: x of the planner, shape (nx,).
            door_disturbance: Estimated torque in the hinge, Coulomb friction included, in the sense of damping [N m].

        Returns:
            The plan, or None before the first one is known.
        """
        if now >= self._next - 1e-9:
            self._next = max(self._next + self.period, now)
            self.planner.update_door(friction=0.0, disturbance=door_disturbance)
            self._plan(now, state)
        while self._waiting and self._waiting[0].available_at <= now + 1e-9:
            self.current = self._waiting.pop(0)
        return self.current

    def _plan(self, now: float, state: np.ndarray) -> None:
        first, self._started = not self._started, True
        plan = self.planner.plan(state) if first else self.planner.replan(state)
        available_at = now + (0.0 if first else self.latency_periods * self.period)
        if plan.flyable:
            self._waiting.append(TimedPlan(plan, now, available_at))
        states, inputs = self._planning.reduced(plan.states, plan.inputs)
        self.recorder.write(
            "plan",
            now,
            {
                "state": states[0],
                "states": states,
                "inputs": inputs,
                "cost": plan.cost,
                "max_violation": plan.max_violation,
                "iterations": plan.iterations,
                "status": plan.status.value,
                "solve_time": plan.solve_time,
                "deadline_missed": bool(not first and plan.solve_time > self.period),
                "available_at": available_at,
            },
        )


class Mission:
    """Opens the door: measure, convert, plan, convert back, control, command, and record all of it.

    Args:
        model: Model of the scenario.
        planner: Planner of the same scenario; made here if not given.
        recorder: Where everything goes; in memory only if not given.
    """

    def __init__(self, model: Model, planner: Planner | None = None, recorder: Recorder | None = None) -> None:
        self.model = model
        self.recorder = recorder or Recorder(None, {})
        self.converter = StateConverter(model)
        settings = model.scenario
        self._schedule = PlanSchedule(
            self._planner_for(model, planner), settings.simulation.planner_latency_periods, self.recorder
        )
        self._controller = PositionController(model.vehicle.mass, GRAVITY, model.vehicle.max_thrust, settings.control)
        self._door_observer = DoorObserver(
            model, settings.control.door_observer_rate, settings.control.max_door_disturbance
        )
        self._last_time: float | None = None
        self._last_yaw = 0.0
        self._hold: Setpoint | None = None
        self._thrust = model.vehicle.mass * GRAVITY

    def fly(self, backend: Backend, duration: float, on_progress: OnProgress | None = None) -> None:
        """Fly for a time; the backend is opened here and stopped whatever happens.

        Args:
            backend: What to fly.
            duration: [s].
            on_progress: Called once per planner period.

        Raises:
            DoormanError: if the backend or an input fails, or this mission has flown before. What was recorded is kept.
        """
        if self._last_time is not None:
            raise DoormanError("a mission flies once; make another one", field="mission")
        started = time.perf_counter()
        now, next_report = 0.0, 0.0
        outcome = "flown to its end"
        try:
            with backend, _no_garbage_collection():
                started = time.perf_counter()
                while now < duration - 1e-9:
                    measurement = backend.read()
                    now = measurement.time
                    angle = self._tick(backend, measurement)
                    if on_progress is not None and now >= next_report:
                        next_report = now + self._schedule.period
                        on_progress(now, angle)
        except KeyboardInterrupt:
            outcome = "interrupted"
            raise
        except Exception as error:
            outcome = f"failed: {error}"
            raise
        finally:
            wall_time = time.perf_counter() - started
            self.recorder.write("mission", now, {"state": "end", "message": outcome, "wall_time": wall_time})

    def _tick(self, backend: Backend, measurement: Measurement) -> float:
        """One period of the controller; returns the estimated door angle."""
        now = measurement.time
        state = self.converter.state(
            measurement.position, measurement.velocity, measurement.attitude,
            measurement.body_rates, measurement.arm_angles, measurement.arm_rates,
        )  # fmt: skip
        state[2] += 2.0 * math.pi * round((self._last_yaw - state[2]) / (2.0 * math.pi))  # yaw without jumps at ±π
        self._last_yaw = float(state[2])
        elapsed = 0.0 if self._last_time is None else now - self._last_time
        self._last_time = now
        force = self._thrust * rotation_body_to_world(measurement.attitude)[:, 2]
        door_disturbance = self._door_observer.update(float(state[3]), float(state[4]), force, elapsed)
        planned_from = self.converter.planner_state(state, measurement.body_rates)
        current = self._schedule.update(now, planned_from, door_disturbance)
        if current is None:
            self._hold = self._hold or self.converter.hold(measurement.position, float(state[2]))
            setpoint = self._hold
        else:
            setpoint = self.converter.setpoint(current.plan, now - current.start, measurement.arm_angles)
        thrust = self._controller.update(measurement.position, measurement.velocity, setpoint, elapsed)
        command = Command(thrust.thrust, self._engaged(thrust.attitude, measurement), setpoint.arm_rates)
        self._thrust = thrust.thrust
        backend.command(command)
        self._record(measurement, state, setpoint, thrust, command)
        return float(state[3])

    @staticmethod
    def _planner_for(model: Model, planner: Planner | None) -> Planner:
        if planner is not None and planner.model.scenario != model.scenario:
            raise DoormanError("the planner was made for another scenario", field="planner")
        return planner or Planner(model)

    def _engaged(self, attitude: np.ndarray, measurement: Measurement) -> np.ndarray:
        """Commanded attitude, its pitch near the measured one at first and free later."""
        settings = self.model.scenario.control
        reach = settings.engage_pitch + settings.engage_rate * measurement.time
        pitch = measurement.attitude[1] + np.clip(attitude[1] - measurement.attitude[1], -reach, reach)
        return np.array([attitude[0], pitch, attitude[2]])

    def _record(
        self, measurement: Measurement, state: np.ndarray, setpoint: Setpoint, thrust: Thrust, command: Command
    ) -> None:
        now, write = measurement.time, self.recorder.write
        write("measurement", now, {name: getattr(measurement, name) for name in _MEASUREMENT_FIELDS})
        write("estimate", now, {"state": state, "door_disturbance": self._door_observer.estimate})
        write("setpoint", now, {name: getattr(setpoint, name) for name in _SETPOINT_FIELDS})
        write("command", now, {name: getattr(command, name) for name in _COMMAND_FIELDS})
        write(
            "controller",
            now,
            {"disturbance": thrust.disturbance, "force": thrust.force, "saturated": thrust.saturated},
        )


def simulate(
    scenario: Scenario | Model,
    duration: float = 12.0,
    seed: int = 0,
    *,
    path: Path | None = None,
    realtime: bool = False,
    planner: Planner | None = None,
    on_progress: OnProgress | None = None,
) -> Recording:
    """Fly a scenario in simulation.

    Args:
        scenario: The scenario, or a model of it that exists already.
        duration: Simulated time, > 0 [s].
        seed: Of the sensors' noise, >= 0.
        path: MCAP file to record to; in memory only if not given.
        realtime: Do not run ahead of the wall clock.
        planner: Planner of the same scenario, to save its construction.
        on_progress: Called once per planner period with time and estimated door angle.

    Returns:
        The recording, with its summary. After Ctrl-C it holds what was flown until then.

    Raises:
        DoormanError: if the scenario is unusable or the simulation fails.
    """
    from doorman import __version__
    from doorman.simulation import SimulatedBackend  # needs the extra `sim`

    if not 0.0 < duration < math.inf:
        raise DoormanError("not a duration", field="duration", given=duration, allowed="> 0 s")
    if seed < 0:
        raise DoormanError("not a seed", field="seed", given=seed, allowed=">= 0")
    model = scenario if isinstance(scenario, Model) else Model(scenario)
    header = {
        "scenario": model.scenario.model_dump(mode="json"),
        "name": model.scenario.name,
        "seed": seed,
        "duration": duration,
        "version": __version__,
    }
    with Recorder(path, header) as recorder:
        mission = Mission(model, planner, recorder)
        backend = SimulatedBackend(model, seed=seed, recorder=recorder, realtime=realtime)
        try:
            mission.fly(backend, duration, on_progress)
        except KeyboardInterrupt:
            pass  # the recording's last mission message says so
        recording = recorder.recording()
    if "truth" in recording and "plan" in recording:  # else interrupted before the first tick
        recording.summary = summarize(recording, model)
    return recording


_MEASUREMENT_FIELDS = ("position", "velocity", "attitude", "body_rates", "arm_angles", "arm_rates")
_SETPOINT_FIELDS = ("position", "velocity", "acceleration", "yaw", "force", "arm_rates")
_COMMAND_FIELDS = ("thrust", "attitude", "arm_rates")


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """No collection in flight: it would stop the controller for milliseconds; reference counts free what a tick makes."""
    enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
