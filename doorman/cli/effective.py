"""The scenario that was really flown, file and overrides together, as TOML."""

from __future__ import annotations

from collections.abc import Mapping

from doorman.scenario import Scenario


def effective_toml(scenario: Scenario, postures: Mapping[str, tuple[float, ...]] | None = None) -> str:
    """A scenario as TOML text that loads as the same task from any directory; see `Scenario.save`.

    Args:
        scenario: The scenario.
        postures: By key, as the scenario's `Model` proposes them; without them they are proposed anew where it is loaded.

    Returns:
        TOML text.

    Raises:
        ScenarioError: if one of its URDFs does not exist.
    """
    return (scenario.replace(postures) if postures else scenario).toml()
