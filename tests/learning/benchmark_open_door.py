"""Steps a second of the environments, beside MuJoCo alone on the same plant with the same physics steps.

Run it by hand: python tests/learning/benchmark_open_door.py [--steps 1000] [--environments 32] [--processes 2]

Processor time counts, of this process and of those that it started, so that other programs do not: `per core` is what one core
steps that has nothing else to do.
"""

from __future__ import annotations

import argparse
import resource
import time

import numpy as np

from doorman.learning import OpenDoorEnv, OpenDoorVectorEnv


def processor_time() -> float:
    return sum(
        usage.ru_utime + usage.ru_stime
        for usage in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--environments", type=int, default=32)
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    alone(options.steps)
    for random in (False, True):
        side_by_side(options, random)


def alone(count: int) -> None:
    env = OpenDoorEnv()
    env.reset(seed=0)
    action = np.zeros(env.action_space.shape)
    begun, episodes = time.process_time(), 1
    for _ in range(count):
        if env.step(action)[2]:
            env.reset()
            episodes += 1
    ours = count / (time.process_time() - begun)
    env.reset(seed=0)
    simulator = env._backend._simulator
    physics = env._ticks * env._backend.steps_per_period
    begun = time.process_time()
    for _ in range(count * physics):
        simulator._mujoco.mj_step(simulator.plant.engine_model, simulator.plant.data)
    engine = count / (time.process_time() - begun)
    begun = time.process_time()
    for _ in range(10):
        env.reset()
    reset = (time.process_time() - begun) / 10
    print(
        f"one: {ours:.0f} steps/s per core, {episodes} episodes; MuJoCo alone {engine:.0f}; a reset {1e3 * reset:.1f} ms"
    )


def side_by_side(options: argparse.Namespace, random: bool) -> None:
    """Hovering, or thrown about by random actions, which ends episodes after a second."""
    before = processor_time()
    envs = OpenDoorVectorEnv(options.environments, processes=options.processes)
    envs.reset(seed=0)
    envs.action_space.seed(0)
    actions = np.zeros(envs.action_space.shape, np.float32)
    rounds, ends, begun = options.steps // options.environments, 0, time.monotonic()
    for _ in range(rounds):
        ends += int(envs.step(envs.action_space.sample() if random else actions)[2].sum())
    wall = time.monotonic() - begun
    envs.close()
    empty = processor_time()
    again = OpenDoorVectorEnv(options.environments, processes=options.processes)
    again.reset(seed=0)
    again.close()
    used = (empty - before) - (processor_time() - empty)  # less what starting costs
    count = rounds * options.environments
    words = "thrown about" if random else "hovering"
    print(
        f"{options.environments} side by side, {words}: {count / wall:.0f} steps/s, {count / used:.0f} per core, {ends} ends"
    )


if __name__ == "__main__":
    main()
