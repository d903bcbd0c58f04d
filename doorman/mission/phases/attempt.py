"""What the phases of one mission share."""

from __future__ import annotations

from doorman.control.at_the_leaf import AtTheLeaf
from doorman.control.estimation.door_locator import place_of
from doorman.control.estimation.estimator import Estimator, Tie
from doorman.control.estimation.loop_test import LoopTest
from doorman.control.estimation.pose_watch import PoseWatch
from doorman.control.passage import Passage, has_doorway
from doorman.control.state_converter import StateConverter
from doorman.mission.opening import Opening
from doorman.mission.schedule import PlanSchedule
from doorman.model import Model
from doorman.planning.pace import RESTING, Pace


class Attempt:
    """The means of a mission, and what the current attempt has come to."""

    def __init__(self, model: Model, converter: StateConverter, schedule: PlanSchedule, estimator: Estimator) -> None:
        self.model, self.converter, self.schedule, self.estimator = model, converter, schedule, estimator
        self.settings = model.scenario.mission
        self.tie = Tie.GRIPPED if model.contact.tied else Tie.PUSHING
        """Tie of the tip to the leaf while it opens the door."""
        self.fastest = Pace.of(model).rate
        """Rate of the door that plans make [rad/s]."""
        self.touch_force = RESTING * model.scale.force
        """With which the tip presses after the touch [N]."""
        self.leaf = AtTheLeaf(model)
        self.opening = Opening(model, schedule)
        through = self.settings.then == "through" and has_doorway(model)
        self.passage = Passage(model) if through else None
        """The way through the doorway, where the vehicle is to fly it."""
        self.number = 1
        self.again = self.aborted = False
        """Whether another attempt follows; whether none may, as the mission was aborted."""
        self.opened = False
        """Whether the door has been brought to the goal."""
        self.failure = ""
        """Why the attempt was given up; empty if it was not."""
        self.seen = ""
        """What the mission has seen of a door that is not where it should be in the end, by its own estimate."""
        self.comes_back = False
        """Whether the vehicle leaves in the end even a door that would not stay: one that has to land must."""
        self.keeps_hold = False
        """Whether the mission ends with the tip on the leaf."""
        self.unsure = False
        """Whether the leaf had to be looked for: contact that is lost again soon may have been none."""
        self.losses = 0
        """Losses of contact so far."""
        self.poses = PoseWatch(model)
        """How old and noisy they are; of all attempts."""
        self.loop_test = LoopTest(model)
        """How the attitude follows its commands; of all attempts."""
        self.place = place_of(model)
        """Where the door stands, as far as that has been found; of all attempts."""

    def allow_another(self) -> None:
        """Let another attempt follow, unless this one has failed already, or the mission was aborted."""
        if not self.failure and not self.aborted:
            knows_the_leaf = self.model.door.side == "push"  # else it may stand open, where the vehicle would come back
            self.again = knows_the_leaf and self.number < self.settings.attempts

    def begin_anew(self) -> str:
        """Another attempt: what was learnt of leaf and hinge is forgotten."""
        reason = f"attempt {self.number + 1}, after: {self.failure}"
        self.number, self.losses, self.failure = self.number + 1, 0, ""
        self.again = self.opened = self.unsure = False
        self.opening = Opening(self.model, self.schedule)
        self.estimator.lose_leaf()
        return reason
