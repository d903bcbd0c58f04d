"""Real time: the planner at 1 kHz on one core, plant and controller on the other; who misses the deadline?

Both run against the clock in processes of their own and share states and plans through memory. The plant is the planner's
model driven by the newest plan, with noise on what is measured. Beside it the controller does its work at its own rate. Every
flight starts with a cold plan, before the clock does.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import time
from multiprocessing.synchronize import Event
from typing import Any

import numpy as np
from numpy.typing import NDArray

import doorman
from doorman.control.position_controller import PositionController
from doorman.control.state_converter import StateConverter
from doorman.gravity import GRAVITY
from suite import standstills
from suite.board import Board, Layout
from suite.session import Session
from suite.standstills import ticks
from suite.statistics import quantiles

Array = NDArray[np.float64]

RATE = 1000.0
"""Of the planner [Hz]."""

BUDGET = 7e-4
"""Of a replan [s]."""

FLIGHT = 10.0
"""Length of a flight [s]."""

NOISE = 1e-3
"""Standard deviation of the measured state [rad, rad/s]."""


def measure(session: Session, seconds: float) -> dict[str, Any]:
    """Plans, missed deadlines, and the planner's times.

    Args:
        session: Its core is the planner's.
        seconds: In all.
    """
    flights = max(round(seconds / FLIGHT), 1)
    length = seconds / flights
    context = multiprocessing.get_context("spawn")
    results = []
    for seed in range(flights):
        board = Board.create(doorman.Model(doorman.Scenario.load("paper")))
        try:
            results.append(_fly(context, board, session.core, length, seed))
        finally:
            board.close()
    return {**_summary(results), "nothing": standstills.measure(RATE, seconds, session.core)}


def _summary(results: list[dict[str, Any]]) -> dict[str, Any]:
    joined = {key: np.concatenate([result[key] for result in results]) for key in ("lateness", "durations", "overrun")}
    left_out = sum(result["left_out"] for result in results)
    late = joined["overrun"] > 0.0
    return {
        "flights": len(results), "rate": RATE, "plans": len(late), "missed": int(late.sum()) + left_out,
        "missed_though_fast": int((late & (joined["durations"] < 0.5 / RATE)).sum()),
        "unusable": sum(result["unusable"] for result in results),
        "real_time_priority": all(result["priority"] for result in results),
        "durations": quantiles(joined["durations"]), "lateness": quantiles(joined["lateness"]),
        "final_door_angles": [result["door_angle"] for result in results],
    }  # fmt: skip


def _fly(context: Any, board: Board, core: int, length: float, seed: int) -> dict[str, Any]:
    other = next((c for c in sorted(os.sched_getaffinity(0)) if c != core), core)
    ready = context.Event()
    receiver, sender = context.Pipe(duplex=False)
    planner = context.Process(target=_plan, args=(board.layout, core, length, ready, sender))
    plant = context.Process(target=_control, args=(board.layout, other, length, seed, ready))
    planner.start()
    plant.start()
    try:
        if not receiver.poll(length + 180.0):
            raise TimeoutError("the planner's process did not answer")
        result: dict[str, Any] = receiver.recv()
    finally:
        for process in (planner, plant):
            process.join(timeout=10.0)
            if process.is_alive():
                process.kill()
    return result


def _plan(layout: Layout, core: int, length: float, ready: Event, sender: Any) -> None:
    """The planner's process."""
    os.sched_setaffinity(0, {core})
    planner = doorman.Planner(doorman.Scenario.load("paper", {"planner.rate": RATE}))
    board = Board(layout)
    board.write_plan(0.0, planner.plan(planner.model.start_state))
    priority = _real_time_priority()
    gc.collect()
    gc.disable()  # as `doorman open` does in flight
    ready.set()
    if not board.wait_for_state(60.0):
        raise TimeoutError("the plant did not start")
    lateness, durations, overrun, unusable = [], [], [], 0
    for tick, deadline in ticks(length, RATE):
        begun = time.perf_counter()
        measured, state = board.read_state()
        plan = planner.replan(state, time_limit=BUDGET)
        unusable += not plan.usable
        if plan.usable:
            board.write_plan(measured, plan)
        done = time.perf_counter()
        lateness.append(begun - tick)
        durations.append(done - begun)
        overrun.append(done - deadline)
    sender.send(
        {
            "lateness": np.array(lateness), "durations": np.array(durations), "overrun": np.array(overrun),
            "unusable": unusable, "left_out": round(length * RATE) - len(durations), "priority": priority,
            "door_angle": float(board.read_state()[1][3]),
        }
    )  # fmt: skip
    board.close()


def _control(layout: Layout, core: int, length: float, seed: int, ready: Event) -> None:
    """Plant and controller."""
    os.sched_setaffinity(0, {core})
    scenario = doorman.Scenario.load("paper", {"planner.rate": RATE})
    model = doorman.Model(scenario)
    converter, motion = StateConverter(model), model.coupling.vehicle_motion
    controller = PositionController(model.vehicle.mass, GRAVITY, model.vehicle.max_thrust, scenario.control)
    rng, board = np.random.default_rng(seed), Board(layout)
    if not ready.wait(120.0):
        raise TimeoutError("the planner's process did not start")
    state, each = np.array(model.start_state), round(RATE / scenario.simulation.controller_rate)
    begun, step = time.perf_counter(), 1.0 / RATE
    for count, _ in enumerate(ticks(length, RATE)):
        now = time.perf_counter() - begun
        start, plan = board.read_plan()
        node = min(int(max(now - start, 0.0) / plan.time_step), len(plan.inputs) - 1)
        inputs = plan.inputs[node]
        state = state + step * model.derivative(state + 0.5 * step * model.derivative(state, inputs), inputs)
        board.write_state(now, state + NOISE * rng.standard_normal(len(state)))
        if count % each == 0:
            setpoint = converter.setpoint(plan, now - start, state[5:])
            body = motion(state, inputs[1:4], inputs[4:])
            controller.update(body.position, body.velocity, setpoint, each * step)
    board.close()


def _real_time_priority() -> bool:
    """Ask for it; most users may not."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
    except PermissionError:
        return False
    return True
