"""What only doors on vertical hinges are planned with is refused elsewhere."""

from __future__ import annotations

import pytest

from doorman import Scenario
from doorman.exceptions import ScenarioError
from doorman.model import Model
from doorman.planning.planning_model import planning_model


@pytest.mark.parametrize("source", ["drawer", "sliding", "hatch"])
@pytest.mark.parametrize(("key", "value"), [("contact.kind", "push"), ("planner.model", "lagrangian")])
def test_pushing_tips_and_full_dynamics_are_refused(source: str, key: str, value: str) -> None:
    model = Model(Scenario.load(f"shipped:{source}", {key: value}))
    with pytest.raises(ScenarioError) as caught:
        planning_model(model)
    assert caught.value.field == key and caught.value.given == value and caught.value.allowed
