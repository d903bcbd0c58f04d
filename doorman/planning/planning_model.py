"""Which model a scenario plans with."""

from __future__ import annotations

from collections.abc import Callable

from doorman.exceptions import ScenarioError
from doorman.model import Model
from doorman.planning.grip.lagrangian_planning import LagrangianPlanning
from doorman.planning.grip.quasi_static_planning import QuasiStaticPlanning
from doorman.planning.model_base import PlanningModel
from doorman.planning.whole_body.planning import WholeBodyPlanning


def planning_model(model: Model) -> PlanningModel:
    """The model that a scenario plans with: by `planner.model`."""
    kinds: dict[str, Callable[[Model], PlanningModel]] = {"whole_body": WholeBodyPlanning}
    if model.contact.tied > 0.0:  # their tip is
        kinds |= {"quasi_static": QuasiStaticPlanning, "lagrangian": LagrangianPlanning}
    given = model.scenario.planner.model
    if given not in kinds:
        raise ScenarioError(
            f'this model does not plan for contact.kind = "{model.scenario.contact.kind}"', file=model.scenario.source,
            field="planner.model", given=given, allowed=", ".join(kinds),
        )  # fmt: skip
    for refused, why in (
        (model.actuation.fully, "this model does not plan for a fully actuated vehicle"),
        (not model.door.vertical, "this model plans only for doors on vertical hinges"),
    ):
        if given == "lagrangian" and refused:
            raise ScenarioError(
                why, file=model.scenario.source, field="planner.model", given=given, allowed="quasi_static"
            )
    return kinds[given](model)
