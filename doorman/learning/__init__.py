"""Learning: doors as Gymnasium environments. Importing it registers them: `gymnasium.make("doorman/OpenDoor-v0")`.

Gymnasium 1.0 and later look for no plugins: a program imports this package, or names it, as in
`gymnasium.make("doorman.learning:doorman/OpenDoor-v0")`. The simulator is loaded when the first environment is made.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from doorman.lazy_names import lazy_names
from doorman.learning.tasks import register_tasks

if TYPE_CHECKING:
    from doorman.learning.open_door import OpenDoorEnv
    from doorman.learning.reward import RewardWeights
    from doorman.learning.side_by_side import OpenDoorVectorEnv

__all__ = ["OpenDoorEnv", "OpenDoorVectorEnv", "RewardWeights"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy_names(
        __name__, {"OpenDoorEnv": "open_door", "OpenDoorVectorEnv": "side_by_side", "RewardWeights": "reward"}
    )

register_tasks()
