"""Learn to open a light door by PPO, from scratch, and draw the learning curve. Needs the extra learn, and some minutes.

python examples/learn_to_open.py --steps 40000 --out learning.png
"""

import argparse
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import VecNormalize

matplotlib.use("agg")
from matplotlib import pyplot as plt  # noqa: E402

TASK = {
    "overrides": {"door.mass": 5.0},
    "rate": 10.0,
    "max_episode_steps": 200,
    "render_mode": None,
}  # a light leaf; 20 s of 10 decisions each


class Episodes(BaseCallback):
    """Notes steps so far, return and outcome of every episode that ends."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[tuple[float, float, float]] = []

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                self.rows.append((self.num_timesteps, info["episode"]["r"], info["opened"]))
        return True


def learn(steps: int, seed: int) -> tuple[PPO, VecNormalize, np.ndarray[Any, Any]]:
    torch.set_num_threads(1)
    environments = VecNormalize(
        make_vec_env("doorman.learning:doorman/OpenDoor-v0", n_envs=8, seed=seed, env_kwargs=TASK), gamma=0.99
    )
    episodes = Episodes()
    policy = PPO(
        "MlpPolicy", environments, n_steps=128, batch_size=128, gamma=0.99, learning_rate=1e-3, seed=seed, device="cpu",
        policy_kwargs={"log_std_init": -1.0},
    )  # fmt: skip
    policy.learn(steps, callback=episodes)
    return policy, environments, np.array(episodes.rows)


def judge(policy: PPO, environments: VecNormalize, count: int) -> float:
    """Share of doors that the mean of the policy opens."""
    environments.training = False
    observations: Any = environments.reset()
    outcomes: list[bool] = []
    while len(outcomes) < count:
        actions, _ = policy.predict(observations, deterministic=True)
        observations, _, over, infos = environments.step(actions)
        outcomes += [info["opened"] for info, ends in zip(infos, over, strict=True) if ends]
    return float(np.mean(outcomes[:count]))


def draw(rows: np.ndarray[Any, Any], file: Path, window: int = 50) -> None:
    """Return and share of opened doors over the steps: mean of the last episodes, and the single ones as dots."""
    window = min(window, len(rows))
    smooth = [np.convolve(column, np.ones(window) / window, "valid") for column in rows.T[1:]]
    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
    above.plot(rows[:, 0], rows[:, 1], ".", ms=2, color="0.7", label="an episode")
    above.plot(rows[window - 1 :, 0], smooth[0], color="#0072b2", label=f"mean of {window} episodes")
    above.axhline(-2.0, color="#d55e00", ls="--", label="hovering for 20 s")
    above.set(ylabel="return")
    above.legend(loc="lower right")
    below.plot(rows[window - 1 :, 0], 100.0 * smooth[1], color="#0072b2")
    below.set(xlabel="steps of the environment", ylabel="doors opened [%]", ylim=(-3, 103))
    figure.savefig(file, dpi=130)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--steps", type=int, default=40_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("learning.png"))
    options = parser.parse_args()
    policy, environments, rows = learn(options.steps, options.seed)
    draw(rows, options.out)
    tenth = max(1, len(rows) // 10)
    print(
        f"return of the first and last tenth of {len(rows)} episodes: {rows[:tenth, 1].mean():.1f}, {rows[-tenth:, 1].mean():.1f}"
    )
    print(f"opened by the trained policy, without exploration: {judge(policy, environments, 50):.0%} of 50 doors")


if __name__ == "__main__":
    main()
