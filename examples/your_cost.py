"""Add a cost of your own: the tip is kept at a depth below the body."""

import doorman

level = doorman.Residual("level tip", lambda task: task.points_in_body["tip"][2] + 0.1, weights=2000.0)
for costs in ([], [level]):
    planner = doorman.Planner("paper", costs=costs)
    plan = planner.plan(planner.model.start_state)
    depths = [planner.model.vehicle.tip_position(state[5:])[2] for state in plan.states]
    print(
        f"{len(costs)} costs of mine: the tip is between {min(depths):.3f} and {max(depths):.3f} m, in the body frame"
    )
