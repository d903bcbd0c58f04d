"""Add a phase of your own: the tip knocks at the leaf twice before it touches it to stay."""

from typing import Any

import doorman
from doorman.mission import Mission, MissionPhase, Next, Phase, Tie
from doorman.recording import Recorder
from doorman.simulation import SimulatedBackend


class Knock(MissionPhase):
    """Forward until the tip feels the leaf, then back for half a second; twice."""

    phase, name, before = Phase.TOUCH, "knock", Phase.TOUCH
    at_the_leaf, tie = True, Tie.PUSHING
    follows = closes_gripper = False  # flown by the position controller, with an open gripper

    def __init__(self, attempt: Any, estimate: Any, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        attempt.leaf.begin(estimate.yaw)
        self.knocks = 0
        self.felt_at: float | None = None

    def step(self, estimate: Any, body_rates: Any, time_step: float) -> tuple[Any, Next | None]:
        """Move the tip along the leaf's normal."""
        if self.felt_at is None and estimate.touching:
            self.felt_at, self.knocks = estimate.time, self.knocks + 1
        if self.felt_at is not None and estimate.time - self.felt_at > 0.5:
            self.felt_at = None
        if self.felt_at is None and self.knocks == 2:
            return self.attempt.leaf.move(estimate, 0.0), Next(Phase.TOUCH)
        return self.attempt.leaf.move(estimate, 0.06 if self.felt_at is None else -0.06), None


for scenario in ("push", "pull"):
    model, recorder = doorman.Model(scenario), Recorder(None, {})
    mission = Mission(model, recorder=recorder, phases=[Knock])
    mission.fly(SimulatedBackend(model, recorder=recorder))
    phases = [str(name) for name in recorder.recording()["mission"]["state"]]
    print(scenario, "opened" if mission.outcome[0] else mission.outcome[1], "after", phases[1:4])
