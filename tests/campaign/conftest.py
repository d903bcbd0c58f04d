"""A campaign of short flights, flown once for all tests that look at its rows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from doorman.campaign import Campaign
from doorman.campaign.running import run_campaign

TASK = """
[contact]
kind = "push"

[mission]
start = "contact"

[simulation.sensors]
latency = 0.02
dropout_rate = 5.0

[campaign]
seed = 17
runs = 5
duration = 0.2

[campaign.vary]
simulation.door_mass = { min = 6.0, max = 20.0 }
simulation.door_friction = { min = 0.1, max = 2.0 }
simulation.gust.vehicle = { mean = 1.0, std = 0.1 }
door.width = { choice = [1.2, 1.3, 0.5] }    # a leaf of 0.5 m does not reach to the contact point
"""
"""Run 1 of it draws the narrow leaf, and no other does."""


@pytest.fixture(scope="session")
def task(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The campaign's scenario."""
    path = tmp_path_factory.mktemp("task") / "short.toml"
    path.write_text(TASK, encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def campaign(task: Path) -> Campaign:
    """The campaign."""
    return Campaign(str(task))


@pytest.fixture(scope="session")
def flown(campaign: Campaign, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[dict[str, Any]]]:
    """Folder and rows of the campaign, flown by two workers."""
    out = tmp_path_factory.mktemp("flown")
    return out, run_campaign(campaign, out, workers=2)
