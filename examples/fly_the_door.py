"""Open the door with the vehicle and say how it went. `open_the_door.py` is the same program in simulation.

Arguments: pixhawk, servos and mocap. The links are those that `doorman rig paper` prints, or those of the hardware.
"""

import math
import sys
from pathlib import Path

from doorman import DoormanError, Model, Scenario
from doorman.flight import FlyingBackend
from doorman.mission import Mission
from doorman.recording import Recorder

model = Model(Scenario.load("paper", overrides={"contact.distance_from_hinge": 0.68}))
recorder = Recorder(Path("runs/fly_the_door.mcap"), {"example": "fly_the_door"})
mission = Mission(model, recorder=recorder)
backend = FlyingBackend(model, *sys.argv[1:], recorder=recorder)  # udp:14540 /dev/ttyUSB0 udp:51001

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
