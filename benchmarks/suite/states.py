"""The states from which everybody plans: along closed loops of exact optima, disturbed ones, and starts off the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suite.judge import Judge, Optimum
from suite.task import Array

NOISE = 1e-2
"""Standard deviation of the disturbance of every state, every step [rad]."""

DOOR_RATE_NOISE = 0.03
"""The same for the door's rate [rad/s]."""


@dataclass(frozen=True)
class Loop:
    """States of a closed loop and the optimum from each."""

    states: list[Array]
    optima: list[Optimum]


def closed_loop(judge: Judge, steps: int, noise_seed: int | None = None) -> Loop:
    """Fly the optimum's first input, plan again, and so on, without model error.

    Args:
        judge: Of the task; its interior-point optima fly the loop, so that no rival does.
        steps: Number of steps; there is one more state.
        noise_seed: Add white noise to the state after every step.
    """
    rng = np.random.default_rng(noise_seed)
    noise = np.full(judge.task.nx, 0.0 if noise_seed is None else NOISE)
    noise[4] = 0.0 if noise_seed is None else DOOR_RATE_NOISE
    state, states, optima = judge.task.start_state, [], []
    for _ in range(steps + 1):
        states.append(state)
        optima.append(judge.optimum(state))
        state = np.array(judge.step(state, optima[-1].inputs[0])).ravel() + noise * rng.standard_normal(len(noise))
    return Loop(states, optima)


def perturbed(loop: Loop, count: int, seed: int) -> list[Array]:
    """States of a loop, drawn at random, with random errors of posture, attitude and rates.

    Args:
        loop: Where to start from.
        count: Number of states.
        seed: Of the draw.
    """
    rng = np.random.default_rng(seed)
    n_arm = len(loop.states[0]) - 5
    spread = np.array([0.1, 0.1, 0.2, 0.15, 0.3, *[0.15] * n_arm])
    return [
        loop.states[int(rng.integers(len(loop.states)))] + spread * rng.standard_normal(len(spread))
        for _ in range(count)
    ]
