"""Use the planner alone, in a loop of your own: your state estimate goes in, thrust, body rates and joint rates come out."""

import numpy as np

import doorman

planner = doorman.Planner("paper")
noise = np.random.default_rng(0)
state = planner.model.start_state
planner.plan(state)
times, command = [], planner.model.hover_input
for _ in range(100):
    estimate = state + 1e-3 * noise.standard_normal(
        state.shape
    )  # [roll, pitch, yaw, door angle, door rate, arm angles]
    plan = planner.replan(estimate)
    if not plan.usable:
        raise SystemExit(f"no plan: {plan.status}, {plan.violated}")
    command = plan.inputs[0]  # thrust, body rates, joint rates
    times.append(plan.solve_time)
    state = plan.states[1]  # your vehicle flies instead
print(f"door at {np.degrees(state[3]):.1f}° after 2 s")
print(f"last command: {command[0]:.1f} N, body {command[1:4].round(2)} rad/s, joints {command[4:].round(2)} rad/s")
print(f"replan: median {1e3 * np.median(times):.2f} ms")
