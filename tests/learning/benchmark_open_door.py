"""Steps a second of the environment, beside MuJoCo alone on the same plant with the same physics steps.

Run it by hand: python tests/learning/benchmark_open_door.py [steps]
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from doorman.learning import OpenDoorEnv


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("steps", nargs="?", type=int, default=1000)
    count = parser.parse_args().steps
    env = OpenDoorEnv()
    env.reset(seed=0)
    action = np.zeros(env.action_space.shape)
    start, episodes = time.perf_counter(), 1
    for _ in range(count):
        if env.step(action)[2]:
            env.reset()
            episodes += 1
    ours = count / (time.perf_counter() - start)
    env.reset(seed=0)
    simulator = env._backend._simulator
    physics = env._ticks * env._backend.steps_per_period
    start = time.perf_counter()
    for _ in range(count * physics):
        simulator._mujoco.mj_step(simulator.plant.engine_model, simulator.plant.data)
    alone = count / (time.perf_counter() - start)
    start = time.perf_counter()
    for _ in range(10):
        env.reset()
    reset = (time.perf_counter() - start) / 10
    print(f"{ours:.0f} steps/s ({ours * physics:.0f} of physics), {episodes} episodes; "
          f"MuJoCo alone {alone:.0f} ({alone * physics:.0f}); a reset {1e3 * reset:.0f} ms")  # fmt: skip


if __name__ == "__main__":
    main()
