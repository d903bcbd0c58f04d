"""Open the door in simulation and say how it went."""

from doorman import DoormanError, Scenario, simulate

scenario = Scenario.load("paper", overrides={"contact.distance_from_hinge": 0.68})
try:
    recording = simulate(scenario, duration=10.0, seed=1)
except DoormanError as error:
    raise SystemExit(f"cannot be simulated: {error}") from error

summary = recording.summary
print(f"the door ended at {summary['final_door_angle_deg']:.1f}°, wanted {summary['target_door_angle_deg']:.1f}°")
if summary["opened"]:
    print(f"it was open after {summary['time_to_open_s']:.1f} s")

truth = recording["truth"]  # every topic is a table of arrays with a time
print(f"largest door rate: {abs(truth['door_rate']).max():.2f} rad/s")
print(f"slowest plan: {recording['plan']['solve_time'].max() * 1e3:.1f} ms")
