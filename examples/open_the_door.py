"""Open the door in simulation and say how it went. `fly_the_door.py` is the same program on the vehicle."""

import math

from doorman import DoormanError, Model, Scenario
from doorman.mission import Mission
from doorman.recording import Recorder
from doorman.simulation import SimulatedBackend

model = Model(Scenario.load("paper", overrides={"contact.distance_from_hinge": 0.68}))
recorder = Recorder(None, {"example": "open_the_door"})
mission = Mission(model, recorder=recorder)
backend = SimulatedBackend(model, seed=1)

try:
    mission.fly(backend)
except DoormanError as error:
    raise SystemExit(f"not flown to its end: {error}") from error
finally:
    recorder.close()

recording = recorder.recording()  # every topic is a table of arrays with a time
opened, reason = mission.outcome
angle = math.degrees(recording["estimate"]["state"][-1, 3])
print("the door was opened" if opened else f"the door was not opened: {reason}")
print(f"the door ended at {angle:.1f}°, wanted {math.degrees(model.goal_angle):.1f}°")
print(f"slowest plan: {recording['plan']['solve_time'].max() * 1e3:.1f} ms")
