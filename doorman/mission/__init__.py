"""Mission: the state machine from hover to hover, and the loop that joins it with planner, controller and a backend."""

from doorman.control.estimation.estimator import Tie as Tie
from doorman.mission.mission import Mission as Mission
from doorman.mission.mission import OnProgress as OnProgress
from doorman.mission.phases.phase import GiveUp as GiveUp
from doorman.mission.phases.phase import MissionPhase as MissionPhase
from doorman.mission.phases.phase import Next as Next
from doorman.mission.phases.phase import Phase as Phase
from doorman.mission.schedule import PlanSchedule as PlanSchedule
from doorman.mission.schedule import TimedPlan as TimedPlan
from doorman.mission.simulate import simulate as simulate
