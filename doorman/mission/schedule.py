"""When to plan, and which plan to follow."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from doorman.ocp.planner import Plan, Planner
from doorman.ocp.planning_model import planning_model
from doorman.recording import Recorder


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

    def update(self, now: float, state: np.ndarray, door_disturbance: float, lean: float = 0.0) -> TimedPlan | None:
        """Plan if it is time to, and return the plan to follow now.

        A plan that is not flyable is recorded and dropped: the last usable one is followed to its end, where it rests.

        Args:
            now: Time of the state [s].
            state: x of the planner, shape (nx,).
            door_disturbance: Estimated torque in the hinge, Coulomb friction included, in the sense of damping [N m].
            lean: By which the vehicle comes nearer to door and frame than a plan knows, as it leans into wind [m].

        Returns:
            The plan, or None before the first one is known.
        """
        if now >= self._next - 1e-9:
            self._next = max(self._next + self.period, now)
            self.planner.update_door(friction=0.0, disturbance=door_disturbance)
            self.planner.update_margin(self.planner.settings.margin + lean)
            self._plan(now, state, door_disturbance)
        while self._waiting and self._waiting[0].available_at <= now + 1e-9:
            self.current = self._waiting.pop(0)
        return self.current

    def forget(self) -> None:
        """Begin anew: what was planned before is not to be followed any more."""
        self._waiting.clear()
        self.current = None
        self._started = False

    def _plan(self, now: float, state: np.ndarray, door_disturbance: float) -> None:
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
                "cold": first,
                "door_disturbance": door_disturbance,
                "margin": self.planner.margin,
                "state": states[0],
                "states": states,
                "inputs": inputs,
                "cost": plan.cost,
                "max_violation": plan.max_violation,
                "violated": plan.violated,
                "iterations": plan.iterations,
                "status": plan.status.value,
                "solve_time": plan.solve_time,
                "deadline_missed": bool(not first and plan.solve_time > self.period),
                "available_at": available_at,
                "normal_force": self.planner.normal_forces(plan),
            },
        )
