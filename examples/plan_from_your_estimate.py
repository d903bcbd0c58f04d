"""Use the planner alone, in a loop of your own: your state estimate goes in, thrust, body rates and joint rates come out."""

import numpy as np

import doorman

planner = doorman.Planner("paper")
noise = np.random.default_rng(0)
state = planner.model.start_state
planner.plan(state)
times = []
for _ in range(100):
    estimate = state + 1e-3 * noise.standard_normal(
        state.shape
    )  # [roll, pitch, yaw, door angle, door rate, arm angles]
    plan = planner.replan(estimate)
    if not plan.usable:
        raise SystemExit(f"no plan: {plan.status}, {plan.violated}")
    thrust, body_rates, joint_rates = plan.inputs[0, 0], plan.inputs[0, 1:4], plan.inputs[0, 4:]
    times.append(plan.solve_time)
    state = plan.states[1]  # your vehicle flies instead
print(f"door at {np.degrees(state[3]):.1f}° after 2 s")
print(f"last command: {thrust:.1f} N, body {body_rates.round(2)} rad/s, joints {joint_rates.round(2)} rad/s")
print(f"replan: median {1e3 * np.median(times):.2f} ms")
