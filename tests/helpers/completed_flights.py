"""Whole flights of shipped tasks, and what every flight that completes its mission has in common."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from doorman import Recording, Scenario, simulate


def completed(
    source: Scenario | str,
    overrides: Mapping[str, Any] | None = None,
    seed: int = 0,
    force: bool = False,
    **most: float,
) -> tuple[dict[str, Any], Recording]:
    """Summary and recording of a flight that touches nothing and ends at its goal: within 1.5°, or 1 cm.

    Args:
        source: A scenario, or a shipped one's name.
        overrides: Of a shipped scenario's keys.
        seed: Of the noise.
        force: Whether it is flown whatever the check says.
        most: Bounds of figures of the summary, by name; `final_error` among them where it is another.
    """
    scenario = Scenario.load(f"shipped:{source}", dict(overrides or {})) if isinstance(source, str) else source
    recording = simulate(scenario, seed=seed, force=force)
    summary = recording.summary
    assert summary is not None and summary["outcome"] == "completed" and summary["collisions"] == 0, summary
    for name, bound in ({"final_error": {"m": 0.01, "deg": 1.5}[summary["unit"]]} | most).items():
        assert abs(summary[name]) < bound, (name, summary[name])
    return dict(summary), recording


def kept_clear(source: str, overrides: Mapping[str, Any] | None = None, seed: int = 0, **most: float) -> dict[str, Any]:
    """The same of a flight that keeps the constraints; a tip that pushes stays on the leaf."""
    summary, recording = completed(source, overrides, seed, False, **most)
    assert summary["min_clearance_m"] > 0.0 and summary["max_constraint_violation_m"] <= 0.01
    if recording.header["scenario"]["contact"]["kind"] == "push":
        assert summary["contact_fraction"] >= 0.97
    return summary
