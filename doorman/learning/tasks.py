"""Names of the environments in Gymnasium's registry."""

from __future__ import annotations

from gymnasium import register

from doorman.resources import scenario_directory, shipped

EPISODE_STEPS = 1000
"""Longest episode: 20 s at 50 steps a second, twice what the planner takes for most tasks."""


def register_tasks() -> None:
    """Register `doorman/OpenDoor-v0`, the paper's door, and `doorman/NAME-v0` for every shipped scenario."""
    names = {"OpenDoor": "paper"} | {name: name for name in shipped(scenario_directory(), ".toml")}
    for name, scenario in names.items():
        register(
            id=f"doorman/{name}-v0", entry_point="doorman.learning.open_door:OpenDoorEnv",
            vector_entry_point="doorman.learning.side_by_side:OpenDoorVectorEnv", kwargs={"scenario": scenario},
            max_episode_steps=EPISODE_STEPS,
        )  # fmt: skip
