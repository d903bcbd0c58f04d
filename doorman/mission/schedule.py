"""When to plan, and which plan to follow."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.control.wanted import Wanted
from doorman.mission.planning_thread import PlanningThread
from doorman.planning.plan import Plan
from doorman.planning.planner import Planner
from doorman.planning.planning_model import planning_model
from doorman.recording import Recorder

_SILENT = 0.5
"""A planner that makes one plan for so long is given up; what is flown meanwhile is the last plan, which is longer [s]."""
_LONGEST = 0.2
"""For one plan where time does not wait: a goal that cannot be reached from a state may take seconds to be given up [s]."""


@dataclass(frozen=True)
class TimedPlan:
    """A plan with the time of the state it starts from, and the time from which it may be used."""

    plan: Plan
    start: float
    available_at: float


@dataclass(frozen=True)
class _Order:
    """A plan that is asked for."""

    time: float
    wanted: Wanted
    margin: float
    cold: bool
    time_limit: float
    epoch: int
    """Orders from before the schedule forgot are of no use any more."""


@dataclass(frozen=True)
class _Answer:
    order: _Order
    state: Array
    """That the plan starts from: the order's, carried on by what was under way."""
    plan: Plan
    normal_force: Array
    user_rows: dict[str, float]
    numbers: Array
    """Numbers of the task that the plan solves."""
    elapsed: float
    """Since the plan before [s]."""


@dataclass
class PlanSchedule:
    """Plans once per period; hands out the newest one that is old enough to be known.

    Plans are made in `update` itself, and taken into use so many periods later. Where time does not wait, they are made in a
    thread of their own while the controller goes on (`running`), and taken into use as soon as they are there.

    Args:
        planner: The planner.
        latency_periods: Periods between the measurement of a state and the use of its plan, where `update` plans.
        recorder: Where every plan goes.
    """

    planner: Planner
    latency_periods: int
    recorder: Recorder
    _waiting: list[TimedPlan] = field(default_factory=list)
    current: TimedPlan | None = None
    """What `update` returned last."""
    refusal: str = ""
    """Why the last plan is not flown; empty if it is."""
    _next: float = 0.0
    _started: bool = False
    _epoch: int = 0
    _planned: float = 0.0
    _thread: PlanningThread[_Order, _Answer] | None = None

    def __post_init__(self) -> None:
        self._planning = planning_model(self.planner.model)

    @property
    def period(self) -> float:
        """Between plans [s]."""
        return 1.0 / self.planner.settings.rate

    @contextmanager
    def running(self, in_background: bool) -> Iterator[None]:
        """Plan in a thread of its own meanwhile, or in `update`.

        Args:
            in_background: Whether in a thread; the planner belongs to it meanwhile.
        """
        if not in_background:
            yield
            return
        with PlanningThread(self._carry_out) as self._thread:
            try:
                yield
            finally:
                self._thread = None

    def update(self, now: float, wanted: Callable[[], Wanted]) -> TimedPlan | None:
        """Plan if it is time to, and return the plan to follow now.

        A plan that is not flyable is recorded and dropped: the last usable one is followed to its end, where it rests.

        Args:
            now: Time of the state [s].
            wanted: Says what to plan; called where a plan is due.

        Returns:
            The plan, or None before the first one is known.

        Raises:
            DoormanError: what the planner raised, in whichever thread.
        """
        thread = self._thread
        if thread is not None and (answer := thread.take()) is not None:
            self._take(answer, now)
        if now >= self._next - 1e-9 and (thread is None or not thread.busy):
            self._next = max(self._next + self.period, now)
            margin, limit = self.planner.settings.margin, math.inf if thread is None else _LONGEST
            order = _Order(now, wanted(), margin, not self._started, limit, self._epoch)
            self._started = True
            if thread is None:
                self._take(self._carry_out(order), now + (0.0 if order.cold else self.latency_periods * self.period))
            else:
                thread.begin(order, now)
        while self._waiting and self._waiting[0].available_at <= now + 1e-9:
            self.current = self._waiting.pop(0)
        return self.current

    def overdue(self, now: float) -> float:
        """How long the planner has been at work on a plan that is not there yet [s].

        Args:
            now: [s].
        """
        return 0.0 if self._thread is None else self._thread.at_work(now)

    def is_silent(self, now: float) -> bool:
        """Whether that is too long."""
        return self.overdue(now) > _SILENT

    def forget(self) -> None:
        """Begin anew: what was planned before is not to be followed any more."""
        self._waiting.clear()
        self.current, self.refusal = None, ""
        self._started = False
        self._epoch += 1

    def _carry_out(self, order: _Order) -> _Answer:
        planner, wanted = self.planner, order.wanted
        planner.update_door(**wanted.hinge._asdict())
        planner.update_margin(order.margin)
        planner.update_goal(wanted.goal)
        elapsed, self._planned = order.time - self._planned, order.time
        if wanted.numbers is None:
            state, make = wanted.state, planner.plan if order.cold else planner.replan
            plan = make(state, time_limit=order.time_limit)
        else:
            planner.update_numbers(wanted.numbers)
            state = planner.carried(wanted.state, wanted.under_way)
            plan = self._follow(order, state, elapsed)
        forces, rows = planner.normal_forces(plan), planner.user_rows()
        return _Answer(order, state, plan, forces, rows, planner.numbers.vector, elapsed)

    def _follow(self, order: _Order, state: Array, elapsed: float) -> Plan:
        """An iteration from the plan before, on new references; one that leads nowhere is made anew."""
        planner = self.planner
        if not order.cold:
            plan = planner.replan(
                state, elapsed, max_iterations=planner.settings.iterations, time_limit=order.time_limit
            )
            if plan.flyable:
                return plan
        return planner.plan(state, time_limit=order.time_limit)

    def _take(self, answer: _Answer, available_at: float) -> None:
        order, plan, rows = answer.order, answer.plan, answer.user_rows
        if order.epoch == self._epoch:
            self.refusal = "" if plan.flyable else f"{plan.status.value} {plan.violated}".rstrip()
            if plan.flyable:
                self._waiting.append(TimedPlan(plan, order.time, available_at))
        states, inputs = self._planning.reduced(plan.states, plan.inputs)
        made_of: dict[str, Any] = {}
        if order.wanted.numbers is not None:
            made_of = {"whole_state": answer.state, "numbers": answer.numbers, "elapsed": answer.elapsed}
        if rows:
            made_of |= {"user_rows": list(rows.values()), "user_row_names": list(rows)}
        self.recorder.write(
            "plan",
            order.time,
            {
                "cold": order.cold,
                "hinge": list(order.wanted.hinge),
                "goal_angle": self.planner.model.goal_angle if order.wanted.goal is None else order.wanted.goal,
                "margin": order.margin,
                "state": states[0],
                "states": states.astype(np.float32),
                "input": inputs[0],
                "cost": plan.cost,
                "max_violation": plan.max_violation,
                "violated": plan.violated,
                "iterations": plan.iterations,
                "status": plan.status.value,
                "solve_time": plan.solve_time,
                "cut_short": bool(plan.solve_time > 0.5 * order.time_limit),
                "deadline_missed": bool(not order.cold and plan.solve_time > self.period),
                "available_at": available_at,
                "least_normal_force": float(answer.normal_force.min()),
                **made_of,
            },
        )
