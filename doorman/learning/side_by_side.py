"""Many environments, spread over processes of which each steps its share."""

from __future__ import annotations

import itertools
import subprocess
import sys
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection, Pipe
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from doorman.checks import numbers, whole
from doorman.copying import Uncopied
from doorman.cores import usable_cores
from doorman.exceptions import BackendError, DimensionError
from doorman.learning.reward import RewardWeights
from doorman.learning.tasks import EPISODE_STEPS
from doorman.resources import own_process
from doorman.scenario import Scenario

Array32 = NDArray[np.float32]
_Answer = tuple[Array32, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]


class OpenDoorVectorEnv(Uncopied, gymnasium.vector.VectorEnv[Array32, Array32, NDArray[Any]]):
    """The same door many times, on all cores: what `gymnasium.make_vec` makes of a task.

    Each process steps its share, one environment after the other. An environment whose episode has ended begins the next one at
    the step after, as Gymnasium's `AutoresetMode.NEXT_STEP` says. The number of processes changes no figure.

    Example:
        >>> import gymnasium
        >>> envs = gymnasium.make_vec("doorman/OpenDoor-v0", 2)
        >>> observations, infos = envs.reset(seed=3)
        >>> observations.shape, float(envs.step(0.0 * envs.action_space.sample())[1].sum()) < 0.0
        ((2, 22), True)
        >>> envs.close()

    Args:
        num_envs: How many environments.
        max_episode_steps: Longest episode.
        scenario: As for `OpenDoorEnv`, like the next three.
        overrides: Keys of the scenario.
        rate: Steps a second [1/s].
        weights: Of the reward.
        processes: Over how many processes to spread them; one for each core by default.

    Attributes:
        observation_names: Of the entries of an observation, with units.
        action_names: Of the entries of an action.

    Raises:
        DoormanError: if the scenario cannot be used, or an option is out of range.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012  # Gymnasium's own

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int = EPISODE_STEPS,
        scenario: Scenario | str = "paper",
        overrides: Mapping[str, Any] | None = None,
        rate: float = 50.0,
        weights: RewardWeights | None = None,
        processes: int | None = None,
    ) -> None:
        self.num_envs = whole(num_envs, "num_envs", 1)
        shares = min(usable_cores() if processes is None else whole(processes, "processes", 1), self.num_envs)
        ends = np.linspace(0, self.num_envs, shares + 1).round().astype(int)
        self._shares = [slice(int(begin), int(end)) for begin, end in zip(ends, ends[1:], strict=False)]
        self._workers = [_Worker() for _ in self._shares]
        task = {"scenario": scenario, "overrides": overrides, "rate": rate, "weights": weights,
                "steps": whole(max_episode_steps, "max_episode_steps", 1)}  # fmt: skip
        try:
            made = self._ask("make", [task | {"count": share.stop - share.start} for share in self._shares])
        except BaseException:
            self.close()
            raise
        self.single_observation_space, self.single_action_space, self.observation_names, self.action_names = made[0]
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array32, dict[str, Any]]:
        """Begin an episode in every environment.

        Args:
            seed: Environment i begins with seed + i, or with its own of a sequence.
            options: None are known.

        Returns:
            Observations, shape (num_envs, 14 + 2 n), and the true door angles [rad].
        """
        seed = [None] * self.num_envs if seed is None else seed
        seeds = range(seed, seed + self.num_envs) if isinstance(seed, int) else seed
        if len(seeds) != self.num_envs:
            raise DimensionError("wrong length", field="seed", given=len(seeds), allowed=str(self.num_envs))
        answers = self._ask("reset", [{"seed": list(seeds[share])} for share in self._shares])
        observations, infos = zip(*answers, strict=True)
        return np.concatenate(observations), self._gathered(infos)

    def step(self, actions: ArrayLike) -> _Answer:
        """Hold an action in every environment for a step.

        Args:
            actions: Shape (num_envs, 4 + n).

        Returns:
            Observations, rewards, whether episodes ended, whether they were cut off, and figures by name, each of num_envs rows.

        Raises:
            DimensionError: if the actions are of another shape.
            BackendError: if `reset` was not called, or an action is not finite.
        """
        checked = numbers(actions, "actions")
        if checked.shape != self.action_space.shape:
            raise DimensionError(
                "wrong shape", field="actions", given=checked.shape, allowed=str(self.action_space.shape)
            )
        answers = self._ask("step", [{"actions": checked[share]} for share in self._shares])
        *parts, infos = zip(*answers, strict=True)
        observations, rewards, terminations, truncations = map(np.concatenate, parts)
        return observations, rewards, terminations, truncations, self._gathered(infos)

    def close_extras(self, **_: Any) -> None:
        """End the processes."""
        for worker in self._workers:
            worker.close()

    def _gathered(self, infos: Sequence[dict[str, Any]]) -> dict[str, Any]:
        """Figures of all shares by name; zero where a share has none, as Gymnasium has it where an environment has none."""
        found: dict[str, Any] = {}
        for name in dict.fromkeys(itertools.chain(*infos)):
            parts = [info.get(name) for info in infos]
            known = next(part for part in parts if part is not None)
            if isinstance(known, dict):
                found[name] = self._gathered([part or {} for part in parts])
            else:
                counts = [share.stop - share.start for share in self._shares]
                filled = (
                    np.zeros(n, known.dtype) if part is None else part for part, n in zip(parts, counts, strict=True)
                )
                found[name] = np.concatenate(list(filled))
        return found

    def _ask(self, name: str, arguments: Sequence[dict[str, Any]]) -> list[Any]:
        """Let all processes do something at the same time; their answers."""
        for worker, each in zip(self._workers, arguments, strict=True):
            worker.send(name, each)
        answers = [worker.receive() for worker in self._workers]
        for answer in answers:
            if isinstance(answer, Exception):
                raise answer
        return answers


class _Worker:
    """A process and the pipe to it; it ends when the pipe closes."""

    def __init__(self) -> None:
        # no `multiprocessing`: its processes would run the caller's script once more
        ours, theirs = Pipe()
        assert isinstance(ours, Connection)
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "doorman.learning.worker", str(theirs.fileno())], pass_fds=[theirs.fileno()],
                env=own_process(), stdin=subprocess.DEVNULL,
            )  # fmt: skip
        self._pipe = ours

    def send(self, name: str, arguments: dict[str, Any]) -> None:
        try:
            self._pipe.send((name, arguments))
        except OSError as error:
            raise BackendError("a process of the environments has ended, or close() was called") from error

    def receive(self) -> Any:
        try:
            return self._pipe.recv()
        except (EOFError, OSError) as error:
            raise BackendError("a process of the environments has ended") from error

    def close(self) -> None:
        self._pipe.close()
        try:
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
