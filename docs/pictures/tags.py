"""Writes tags.png and tags_push.png: a push as the vehicle's camera sees it, with the tags that the detector finds.

The postures are those of the task's way from start to goal. Rendering off screen needs EGL (Debian and Ubuntu: libegl1 libgl1).

Usage: python docs/pictures/tags.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from doorman.door_sensor.detector import SeenTag, opencv
from doorman.door_sensor.printing import usual_camera, usual_marks
from doorman.kinematics.rotations import quaternion_of
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.simulation.door_sensor.pictures import PictureSensor
from doorman.simulation.plant.engine import engine
from doorman.simulation.simulator import Simulator

PICTURES = Path(__file__).parent
OPENINGS = (0.0, 25.0, 50.0)
"""That are shown [deg]."""
_GREEN, _THICK = (40, 220, 40), 2


def drawn(picture: NDArray[np.uint8], seen: dict[int, SeenTag]) -> NDArray[np.uint8]:
    """A picture with the tags that were found in it.

    Args:
        picture: Colours, shape (height, width, 3).
        seen: Tags by number.
    """
    cv, shown = opencv(), picture.copy()
    for number, tag in seen.items():
        corners = np.round(tag.corners).astype(np.int32)
        cv.polylines(shown, [corners], True, _GREEN, _THICK)
        x, y = (int(value) for value in corners.min(axis=0))
        cv.putText(shown, f"tag {number}", (x, y - 8), cv.FONT_HERSHEY_SIMPLEX, 0.6, _GREEN, _THICK)
    return np.asarray(shown)


def pose(simulator: Simulator, model: Model, opening: float) -> None:
    """Put the plant where the task has it at an opening [rad]; a closed door is seen from the hover."""
    plant, state = simulator.plant, model.on_the_way(model.door.angle_of_opening(opening))
    data, rotation = plant.data, np.linalg.inv(plant.root_to_base)
    if opening > 0.0:
        place = model.coupling.vehicle_position(state[:3], float(state[3]), state[5:])
        data.qpos[:3] = place + rotation[:3, 3]
        data.qpos[3:7] = quaternion_of(state[:3])
        data.qpos[plant.arm_positions] = state[5:]
    data.qpos[plant.hinge_position] = model.door.joint_value(float(state[3]))


def main() -> None:
    """Take the pictures."""
    cv = opencv()
    model = Model(Scenario.load("push", {"simulation.door_sensor.kind": "pictures"}))
    simulator = Simulator(model, 1e-3)
    camera = usual_camera(model.scenario.simulation.door_sensor.field_of_view)
    pictures, kept = PictureSensor(engine(), simulator, usual_marks(model), camera, 0), []
    for opening in OPENINGS:
        pose(simulator, model, math.radians(opening))
        pictures.look(0.0, np.zeros(3), np.zeros(3))
        kept.append(drawn(pictures.colours(), pictures.seen))
        print(f"{opening:.0f}°: tags {', '.join(map(str, sorted(pictures.seen))) or 'none'}")
    pictures.close()
    cv.imwrite(str(PICTURES / "tags.png"), cv.cvtColor(kept[0], cv.COLOR_RGB2BGR))
    small = [cv.resize(one, None, fx=0.5, fy=0.5, interpolation=cv.INTER_AREA) for one in kept]
    cv.imwrite(str(PICTURES / "tags_push.png"), cv.cvtColor(np.hstack(small), cv.COLOR_RGB2BGR))


if __name__ == "__main__":
    main()
