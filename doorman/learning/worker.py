"""The process that steps a share of many environments: `python -m doorman.learning.worker FILE_DESCRIPTOR`."""

from __future__ import annotations

import sys
from multiprocessing.connection import Connection
from typing import Any

from gymnasium.vector import SyncVectorEnv
from gymnasium.wrappers import TimeLimit

from doorman.learning.open_door import OpenDoorEnv, model_of


def main() -> None:
    """Make a share, then call its methods by name, until the parent process has ended."""
    share: SyncVectorEnv[Any, Any] | None = None
    with Connection(int(sys.argv[1])) as pipe:
        while True:
            try:
                name, arguments = pipe.recv()
            except EOFError:
                return
            try:
                if share is None:
                    share = made(**arguments)
                    first = share.envs[0].unwrapped
                    names = first.observation_names, first.action_names  # type: ignore[attr-defined]  # OpenDoorEnv's
                    answer: Any = share.single_observation_space, share.single_action_space, *names
                else:
                    answer = getattr(share, name)(**arguments)
            except Exception as error:
                answer = error
            pipe.send(answer)


def made(count: int, steps: int, scenario: Any, overrides: Any, rate: float, weights: Any) -> SyncVectorEnv[Any, Any]:
    """Environments that share one model, stepped one after the other; one that has ended begins anew with the step after."""
    model = model_of(scenario, overrides)
    return SyncVectorEnv([lambda: TimeLimit(OpenDoorEnv(model, None, rate, weights), steps)] * count, copy=False)


if __name__ == "__main__":
    main()
