"""Fly the same task with several seeds of noise and gusts, and compare."""

import numpy as np

from doorman import Model, Scenario, simulate

model = Model(Scenario.load("paper", overrides={"simulation.noise.position": 0.001, "mission.start": "contact"}))
angles = []
for seed in range(3):
    recording = simulate(model, duration=5.0, seed=seed)
    angles.append(recording.summary["final_door_angle_deg"])
    print(f"seed {seed}: {angles[-1]:.2f}°, largest violation {recording.summary['max_constraint_violation_m']:.4f} m")
print(f"mean {np.mean(angles):.2f}°, standard deviation {np.std(angles):.2f}°")
