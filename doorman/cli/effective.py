"""The scenario that was really flown, file and overrides together, as TOML."""

from __future__ import annotations

from collections.abc import Mapping

from doorman.scenario import Scenario


def effective_toml(scenario: Scenario, postures: Mapping[str, tuple[float, ...]] | None = None) -> str:
    """A scenario as TOML text that loads as the same task from any directory; see `Scenario.save`."""
    return (scenario.replace(postures) if postures else scenario).toml()
