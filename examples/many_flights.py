"""Fly the same task with several seeds of noise and gusts, on all cores, and compare."""

import numpy as np

from doorman import Scenario, simulate_batch

scenario = Scenario.load("paper", overrides={"simulation.noise.position": 0.001, "mission.start": "contact"})
angles = []
for flight in simulate_batch(scenario, range(3), duration=5.0):
    if flight.summary is None:
        raise SystemExit(f"seed {flight.seed}: {flight.error}")
    angles.append(flight.summary["final_door_angle_deg"])
    violation = flight.summary["max_constraint_violation_m"]
    print(f"seed {flight.seed}: {angles[-1]:.2f}°, largest violation {violation:.4f} m, in {flight.wall_time:.1f} s")
print(f"mean {np.mean(angles):.2f}°, standard deviation {np.std(angles):.2f}°")
