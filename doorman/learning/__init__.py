"""Learning: the door as a Gymnasium environment, `gymnasium.make("doorman.learning:doorman/OpenDoor-v0")`."""

import gymnasium

from doorman.learning.open_door import OpenDoorEnv
from doorman.learning.reward import RewardWeights

__all__ = ["OpenDoorEnv", "RewardWeights"]

gymnasium.register(id="doorman/OpenDoor-v0", entry_point="doorman.learning.open_door:OpenDoorEnv")
