"""The process that steps a share of many environments: `python -m doorman.learning.worker FILE_DESCRIPTOR`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.learning.open_door import OpenDoorEnv, model_of


def main() -> None:
    share: Share | None = None
    with Connection(int(sys.argv[1])) as pipe:
        while True:
            try:
                name, arguments = pipe.recv()
            except EOFError:  # the parent process has ended
                return
            try:
                if share is None:
                    share = Share(**arguments)
                    answer: Any = share.spaces
                else:
                    answer = getattr(share, name)(**arguments)
            except Exception as error:
                answer = error
            pipe.send(answer)


class Share:
    """Environments that share one model, stepped one after the other; one that has ended begins anew with the step after."""

    def __init__(self, count: int, steps: int, scenario: Any, overrides: Any, rate: float, weights: Any) -> None:
        model = model_of(scenario, overrides)
        self._all = [OpenDoorEnv(model, None, rate, weights) for _ in range(count)]
        self._longest, self._taken = steps, [0] * count
        self._over = [False] * count
        first = self._all[0]
        self.spaces = first.observation_space, first.action_space, first.observation_names, first.action_names
        self._seen = np.zeros((count, len(first.observation_names)), np.float32)

    def reset(self, seeds: Sequence[int | None]) -> tuple[NDArray[np.float32], list[dict[str, Any]]]:
        return self._seen, [self._begin(i, seed) for i, seed in enumerate(seeds)]

    def step(self, actions: NDArray[np.float32]) -> tuple[Any, ...]:
        """Observations, rewards, ends, cuts and figures, row by row."""
        rows = [self._begun(i) if self._over[i] else self._step(i, action) for i, action in enumerate(actions)]
        rewards, ends, cuts, infos = zip(*rows, strict=True)
        return self._seen, np.array(rewards), np.array(ends), np.array(cuts), infos

    def _step(self, i: int, action: NDArray[np.float32]) -> tuple[float, bool, bool, dict[str, Any]]:
        self._seen[i], reward, ended, _, info = self._all[i].step(action)
        self._taken[i] += 1
        cut = self._taken[i] >= self._longest
        self._over[i] = ended or cut
        return reward, ended, cut, info

    def _begun(self, i: int) -> tuple[float, bool, bool, dict[str, Any]]:
        return 0.0, False, False, self._begin(i, None)

    def _begin(self, i: int, seed: int | None) -> dict[str, Any]:
        self._seen[i], info = self._all[i].reset(seed=seed)
        self._taken[i], self._over[i] = 0, False
        return info


if __name__ == "__main__":
    main()
