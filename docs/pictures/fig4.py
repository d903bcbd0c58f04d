"""Fly the task `fig4`, draw it in the layout of the paper's Fig. 4, and write the table of docs/fig4.md.

Usage: python docs/pictures/fig4.py
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from doorman import Model, Recording, Scenario, simulate
from doorman.visualization import paper_figure
from doorman.visualization.files import save_as

DOCS = Path(__file__).parents[1]
PAGE, PICTURE = DOCS / "fig4.md", DOCS / "pictures" / "fig4.png"
TABLE = re.compile(r"(?<=<!-- numbers -->\n).*(?=<!-- end -->)", re.DOTALL)
WITHIN = 2.0
"""Of the goal: the door counts as there [°]."""


def table(recording: Recording, model: Model) -> str:
    """What the paper says of its figure, point by point, beside the same of a flight."""
    estimate, truth, summary = recording["estimate"], recording["truth"], recording.summary
    roll, pitch, yaw, angle = np.degrees(estimate["state"][:, :4]).T
    goal = np.degrees(model.goal_state)
    away = np.abs(angle - goal[3]) > WITHIN
    there = float(estimate.time[np.flatnonzero(away)[-1] + 1] - estimate.time[0])
    arm = ", ".join(f"{value:.1f}°" for value in np.degrees(estimate["state"][-1, 5:]))
    wanted = ", ".join(f"{value:.0f}°" for value in goal[5:])
    rows = [
        ("start", "α = π/2, the door at rest", f"α = {angle[0]:.1f}°, {abs(float(truth['door_rate'][0])):.2f} rad/s"),
        ("desired state", "ψ = −7π/18, α = π/9, H = [0, π/2, −π/2, 0]",
         f"ψ = {goal[2]:.0f}°, α = {goal[3]:.0f}°, H = [{wanted}]"),
        ("door angle", "α tends to converge to the desired value",
         f"within {WITHIN:g}° from {there:.1f} s on, {angle[-1]:.1f}° at the end"),
        ("heading", "ψ follows the changes of α",
         f"{yaw[-1]:.1f}° at the end; at most {np.abs(yaw - (angle - 90.0)).max():.1f}° beside the leaf's normal"),
        ("roll and pitch", "shown, not discussed",
         f"at most {np.abs(roll).max():.1f}° and {np.abs(pitch).max():.1f}°, {roll[-1]:.1f}° and {pitch[-1]:.1f}° at the end"),
        ("arm", "shown, not discussed", f"H = [{arm}] at the end"),
        ("discrepancies", "in α and ψ, as the tip leaves the door now and then",
         f"{abs(angle[-1] - goal[3]):.1f}° and {abs(yaw[-1] - goal[2]):.1f}° at the end; "
         f"the tip is at the leaf for {100.0 * float(summary['contact_fraction']):.0f} % of the time"),
        ("collisions", "none", f"{summary['collisions']} contacts other than tip and leaf"),
    ]  # fmt: skip
    lines = ["| point | paper | doorman |", "| --- | --- | --- |", *(f"| {' | '.join(row)} |" for row in rows)]
    return re.sub(r"-(?=\d)", "−", "\n".join(lines)) + "\n"


def main() -> None:
    """Fly, draw and write."""
    model = Model(Scenario.load("fig4"))
    recording = simulate(model, seed=0)
    save_as(paper_figure(recording, model), PICTURE)
    PAGE.write_text(TABLE.sub(lambda _: table(recording, model), PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
