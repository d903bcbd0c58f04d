"""The mission loop tick by tick, on a scripted backend: rates, latency, what is commanded, and how flights end."""

from __future__ import annotations

import dataclasses
import gc
import math
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from doorman import Model, Planner, PlanStatus, Scenario
from doorman.control.wanted import Wanted
from doorman.exceptions import BackendError, DoormanError
from doorman.hardware.interface import Backend, Command, Measurement
from doorman.mission import Mission, PlanSchedule
from doorman.planning.hinge import Hinge
from doorman.recording import Recorder, Recording

TICK = 0.004
TUG = 0.9
"""In contact a mission begins by trying its gripper; plans are asked for after that [s]."""


@pytest.fixture(scope="module")
def model() -> Model:
    """The paper's task from the touch on."""
    return Model(Scenario.load("paper", {"mission.start": "contact"}))


class ScriptedBackend(Backend):
    """A vehicle held at the scenario's start, whose measurements may be changed by a script."""

    def __init__(self, model: Model, change: Callable[[Measurement], Measurement] = lambda measurement: measurement):
        self.model, self.change = model, change
        self.commands: list[Command] = []
        self.opened = self.stopped = self.ticks = 0

    def open(self) -> None:
        self.opened += 1

    def read(self) -> Measurement:
        x, rest = self.model.start_state, np.zeros(3)
        position = self.model.coupling.vehicle_position(x[:3], x[3], x[5:])
        arm = np.zeros(self.model.n_arm)
        measurement = Measurement(
            TICK * self.ticks, position, rest, x[:3].copy(), rest, x[5:].copy(), arm, TICK * self.ticks
        )
        self.ticks += 1
        return self.change(measurement)

    def command(self, command: Command) -> None:
        self.commands.append(command)

    def stop(self) -> None:
        self.stopped += 1


class NotedPlanner(Planner):
    """Planner that notes its calls and may be told which of its plans are of no use."""

    def __init__(self, model: Model, useless: set[int] = frozenset()):  # type: ignore[assignment]
        super().__init__(model)
        self.useless, self.calls, self.told, self.limits = useless, [], [], set[float]()

    def update_door(self, **torques: float) -> None:
        self.told.append(torques)
        super().update_door(**torques)

    def plan(self, state, **options):
        self.limits.add(options["time_limit"])
        return self._noted("plan", super().plan(state, **options))

    def replan(self, state, elapsed=None, **options):
        self.limits.add(options["time_limit"])
        return self._noted("replan", super().replan(state, elapsed, **options))

    def _noted(self, kind, plan):
        self.calls.append(kind)
        if len(self.calls) in self.useless:
            plan = dataclasses.replace(plan, status=PlanStatus.INFEASIBLE)
        return plan


def opening(recorder: Recorder) -> tuple[int, Recording]:
    """Tick in which the opening begins, and what was recorded."""
    recording = recorder.recording()
    mission = recording["mission"]
    began = mission.time[mission["state"].tolist().index("open")]
    return int(np.searchsorted(recording["setpoint"].time, began)), recording


class Asked:
    """A schedule whose controller is at the start, at a hinge that nothing resists in."""

    def __init__(self, planner: Planner, latency: int) -> None:
        self.schedule, self.planner = PlanSchedule(planner, latency, Recorder(None, {})), planner
        self.wanted = Wanted(planner.model.start_state, Hinge(0.0, 0.0, 5.0, 0.0, 0.0))

    def at(self, time: float) -> Any:
        """The plan that is followed then."""
        return self.schedule.update(time, lambda: self.wanted)

    @property
    def plans(self) -> Any:
        return self.schedule.recorder.recording()["plan"]


@pytest.mark.parametrize("latency", [0, 1, 3])
def test_plans_come_at_the_planners_rate_and_are_known_later(model: Model, latency: int) -> None:
    asked = Asked(NotedPlanner(model), latency)
    starts = [asked.at(TICK * k).start for k in range(250)]
    ages, calls = TICK * np.arange(250) - starts, asked.planner.calls
    assert calls[0] == "plan" and set(calls[1:]) == {"replan"}
    assert len(calls) == 100
    assert (np.diff(starts) >= 0.0).all()
    assert ages[50:].min() >= 0.01 * latency - 1e-9
    assert ages[50:].max() <= 0.01 * latency + 0.01 + TICK
    assert asked.plans["available_at"][1:] == pytest.approx(asked.plans.time[1:] + 0.01 * latency)


def test_a_slow_controller_plans_once_a_tick(model: Model) -> None:
    asked = Asked(NotedPlanner(model), 1)
    for k in range(20):
        asked.at(0.05 * k)
    assert len(asked.planner.calls) == 20


def test_useless_plans_are_recorded_and_not_followed(model: Model) -> None:
    asked = Asked(NotedPlanner(model, useless=set(range(3, 8))), 0)
    starts = [asked.at(0.01 * k).start for k in range(10)]
    assert starts == pytest.approx([0.0, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.07, 0.08, 0.09])
    assert asked.plans["status"].tolist().count("infeasible") == 5


def test_nothing_to_follow_before_the_first_usable_plan(model: Model) -> None:
    asked = Asked(NotedPlanner(model, useless={1, 2}), 2)
    followed = [asked.at(0.01 * k) for k in range(6)]
    assert followed[:4] == [None] * 4
    assert followed[4] is not None and followed[4].start == pytest.approx(0.02)


def test_the_planner_is_told_the_hinge(model: Model) -> None:
    asked, hinge = Asked(NotedPlanner(model), 0), Hinge(0.1, -0.7, 4.0, 0.6, 0.9)
    asked.wanted = Wanted(model.start_state, hinge)
    asked.at(0.0)
    assert asked.planner.told == [hinge._asdict()]


def test_first_plan_misses_no_deadline_others_may(model: Model) -> None:
    class SlowPlanner(NotedPlanner):
        def _noted(self, kind, plan):
            return dataclasses.replace(super()._noted(kind, plan), solve_time=0.011 if len(self.calls) != 2 else 0.009)

    asked = Asked(SlowPlanner(model), 0)
    for k in range(3):
        asked.at(0.01 * k)
    assert asked.plans["deadline_missed"].tolist() == [False, False, True]


def test_a_flight_opens_ticks_records_and_stops(model: Model) -> None:
    backend, recorder, reports = ScriptedBackend(model), Recorder(None, {}), []
    assert gc.isenabled()
    Mission(model, recorder=recorder).fly(
        backend, 0.2, lambda time, angle: reports.append((time, angle, gc.isenabled()))
    )
    recording = recorder.recording()
    assert (backend.opened, backend.stopped, backend.ticks) == (1, 1, 51)
    assert len(backend.commands) == 51
    for topic in ("measurement", "estimate", "setpoint", "command", "controller"):
        np.testing.assert_allclose(recording[topic].time, TICK * np.arange(51))
    assert recording["mission"]["state"].tolist() == ["touch", "end"]
    assert recording["mission"]["message"].tolist() == ["", "flown to its end"]
    times, angles, collected = zip(*reports, strict=True)
    assert 15 <= len(times) <= 21
    np.testing.assert_allclose(angles, math.pi / 2, atol=1e-4)
    assert not any(collected) and gc.isenabled()
    np.testing.assert_allclose(recording["estimate"]["state"], np.tile(model.start_state, (51, 1)), atol=1e-3)
    for k, command in enumerate(backend.commands):
        assert recording["command"]["thrust"][k] == command.thrust
        assert command.thrust == pytest.approx(float(np.linalg.norm(recording["controller"]["force"][k])), rel=5e-3)
        np.testing.assert_array_equal(recording["command"]["attitude"][k], command.attitude)
        assert (np.abs(command.arm_rates) <= model.vehicle.rate_limits + 1e-12).all()


@pytest.mark.parametrize("real_time", [False, True])
def test_a_plant_that_goes_on_is_planned_for_in_another_thread(model: Model, real_time: bool) -> None:
    class ThreadedPlanner(NotedPlanner):
        def _noted(self, kind, plan):
            self.told.append(threading.current_thread())
            return super()._noted(kind, plan)

        def update_door(self, **torques: float) -> None:
            Planner.update_door(self, **torques)

    def slowly(measurement: Measurement) -> Measurement:
        time.sleep(TICK)
        return measurement

    planner, backend = ThreadedPlanner(model), ScriptedBackend(model, slowly)
    backend.real_time = real_time
    before = threading.active_count()
    Mission(model, planner).fly(backend, TUG + 0.3)
    assert len(planner.calls) > 3
    limited = max(planner.limits) < 0.5
    assert limited is real_time, "one plan must not take for ever; in simulation it may, and is the same each time"
    assert (threading.main_thread() in planner.told) is not real_time
    assert threading.active_count() == before, "the thread has ended"


def test_yaw_does_not_jump_at_half_a_turn(model: Model) -> None:
    """Sensors wrap at ±π; the planner's states and the setpoints go on."""

    def turning(measurement: Measurement) -> Measurement:
        yaw = -3.0 - 0.5 * measurement.time
        wrapped = (yaw + math.pi) % (2.0 * math.pi) - math.pi
        turns = np.array([0.0, 0.0, -0.5])
        return dataclasses.replace(measurement, attitude=np.array([0.0, 0.0, wrapped]), body_rates=turns)

    recorder = Recorder(None, {})
    Mission(model, recorder=recorder).fly(ScriptedBackend(model, turning), 0.8)
    recording = recorder.recording()
    assert np.abs(np.diff(recording["measurement"]["attitude"][:, 2])).max() > 6.0
    np.testing.assert_allclose(recording["estimate"]["state"][:, 2], -3.0 - 0.5 * recording["estimate"].time, atol=1e-3)


def test_without_any_usable_plan_the_first_position_is_held(model: Model) -> None:
    def drifting(measurement: Measurement) -> Measurement:
        return dataclasses.replace(
            measurement, position=measurement.position + [0.0, 0.0, 0.1 * max(measurement.time - TUG, 0.0)]
        )

    backend, recorder = ScriptedBackend(model, drifting), Recorder(None, {})
    planner = NotedPlanner(model, useless=set(range(1000)))
    Mission(model, planner, recorder).fly(backend, TUG + 0.4)
    begins, recording = opening(recorder)
    setpoint = {name: recording["setpoint"][name][begins + 1 :] for name in ("position", "arm_rates", "force")}
    assert np.ptp(setpoint["position"], axis=0).max() < 0.02
    assert len(setpoint["position"]) > 90
    assert not setpoint["arm_rates"].any() and not setpoint["force"].any()
    assert backend.commands[-1].thrust < backend.commands[begins].thrust


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (BackendError, "failed: no pose for 0.1 s"),
        (ZeroDivisionError, "failed: no pose for 0.1 s"),
        (KeyboardInterrupt, "interrupted"),
    ],
)
def test_however_a_flight_ends_the_backend_is_stopped_and_it_is_recorded(
    model: Model, error: type[BaseException], message: str
) -> None:
    def failing(measurement: Measurement) -> Measurement:
        if measurement.time > 0.1:
            raise error("no pose for 0.1 s")
        return measurement

    backend, recorder = ScriptedBackend(model, failing), Recorder(None, {})
    with pytest.raises(error):
        Mission(model, recorder=recorder).fly(backend, 1.0)
    assert backend.stopped == 1 and gc.isenabled()
    recording = recorder.recording()
    assert recording["mission"]["message"].tolist() == ["", message]
    assert recording["measurement"].time[-1] == pytest.approx(0.1)
    assert recording["mission"]["wall_time"][-1] > 0.0


def test_a_measurement_that_is_not_finite_ends_the_flight(model: Model) -> None:
    def blind(measurement: Measurement) -> Measurement:
        return dataclasses.replace(measurement, position=np.full(3, np.nan)) if measurement.time > 0.1 else measurement

    backend = ScriptedBackend(model, blind)
    with pytest.raises(DoormanError, match="position"):
        Mission(model).fly(backend, 1.0)
    assert backend.stopped == 1
    assert all(np.isfinite(command.attitude).all() for command in backend.commands)


def test_an_estimate_that_is_lost_ends_the_mission(model: Model) -> None:
    """No input is known to bring that about: the covariances are made meaningless."""
    mission = Mission(model)

    def broken(measurement: Measurement) -> Measurement:
        if measurement.time == pytest.approx(0.1, abs=0.5 * TICK):
            mission._estimator._bank._memory.kept_covariances[:] = np.nan
        return measurement

    backend = ScriptedBackend(model, broken)
    mission.fly(backend, 0.3)
    assert mission.outcome == (False, "the estimate was lost") and backend.stopped == 1
    assert all(np.isfinite(command.attitude).all() for command in backend.commands)


def test_a_mission_flies_once(model: Model) -> None:
    mission = Mission(model)
    mission.fly(ScriptedBackend(model), 0.02)
    again = ScriptedBackend(model)
    with pytest.raises(DoormanError, match="flies once"):
        mission.fly(again, 0.02)
    assert again.opened == 0


def test_the_door_observer_can_be_switched_off() -> None:
    model = Model(Scenario.load("paper", {"control.door_observer_rate": 0.0, "mission.start": "contact"}))
    planner = NotedPlanner(model)
    Mission(model, planner).fly(ScriptedBackend(model), TUG + 0.1)
    assert max(abs(told["disturbance"]) for told in planner.told) < 0.05


def test_readings_of_the_tip_s_force_are_a_topic_of_their_own_where_there_are_any(model: Model) -> None:
    """A sensor may fail at any tick, and recordings without one stay as they are."""
    recordings = []
    for begins in (math.inf, 0.03):
        mission = Mission(model)

        def reads(one: Measurement, begins: float = begins) -> Measurement:
            return dataclasses.replace(one, tip_force=1.5 if one.time > begins else None)

        mission.fly(ScriptedBackend(model, reads), 0.06)
        recordings.append(mission.recorder.recording())
        assert "tip_force" not in set(recordings[-1]["measurement"])
    assert "tip_sensor" not in recordings[0]
    felt = recordings[1]["tip_sensor"]
    assert set(felt["force"]) == {1.5} and felt.time[0] > 0.03
