"""The scenario that was really flown, file and overrides together, as TOML."""

from __future__ import annotations

from doorman.scenario import Scenario


def effective_toml(scenario: Scenario) -> str:
    """A scenario as TOML text that loads as the same task from any directory; see `Scenario.save`.

    Args:
        scenario: The scenario.

    Returns:
        TOML text.

    Raises:
        ScenarioError: if one of its URDFs does not exist.
    """
    return scenario.toml()
