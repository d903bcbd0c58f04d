"""What only doors on vertical hinges are planned with is refused elsewhere."""

from __future__ import annotations

import pytest

from doorman import Scenario
from doorman.exceptions import ScenarioError
from doorman.model import Model
from doorman.planning.planning_model import planning_model


@pytest.mark.parametrize("source", ["drawer", "sliding", "hatch"])
def test_full_dynamics_are_refused(source: str) -> None:
    model = Model(Scenario.load(f"shipped:{source}", {"planner.model": "lagrangian"}))
    with pytest.raises(ScenarioError) as caught:
        planning_model(model)
    assert caught.value.field == "planner.model" and caught.value.given == "lagrangian" and caught.value.allowed
