"""Add a constraint of your own: the vehicle stays below a ceiling."""

import doorman

ceiling = doorman.Constraint("ceiling", lambda task: task.position[2] - 1.32, unit="m")
for constraints in ([], [ceiling]):
    planner = doorman.Planner("paper", constraints=constraints)
    state, highest = planner.model.start_state, 0.0
    planner.plan(state)
    for _ in range(100):  # two seconds, as if the vehicle followed perfectly
        plan = planner.replan(state)
        state = plan.states[1]
        position = planner.model.coupling.vehicle_position(state[:3], state[3], state[5:])
        highest = max(highest, float(position[2]))
    print(f"{len(constraints)} constraints of mine: the vehicle rises to {highest:.3f} m")
