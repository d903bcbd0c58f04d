"""The replay's door stands where the simulated one does."""

import numpy as np

from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.visualization.scene.drawing import Drawing
from doorman.visualization.scene.moments import Moment


def test_leaf_and_frame_are_drawn_where_they_truly_stand(model):
    yaw, angle = 0.1, 1.2
    keys = {"simulation.door_offset": [0.05, 0.0, 0.0], "simulation.door_yaw": yaw, "simulation.door_face_offset": 0.04}
    drawing = Drawing(Model(model.scenario.replace(keys)))
    scene = drawing.scene()
    moment = Moment(0.0, np.array([-1.0, 0.7, 1.2]), np.zeros(3), angle, model.goal_arm, None, None, "", "")
    leaf = drawing.frame(moment)["poses"][scene["nodes"].index("scene/door/leaf")]
    turn = rotation_body_to_world([0.0, 0.0, angle + yaw])
    np.testing.assert_allclose(leaf[:3], [0.05, 0.0, 0.4] + turn @ [0.0, 0.04, 0.0], atol=1e-4)
    np.testing.assert_allclose(leaf[3:], [0.0, 0.0, np.sin((angle + yaw) / 2), np.cos((angle + yaw) / 2)], atol=1e-5)
    (frame,) = [one for one in scene["commands"] if one.get("path") == "/scene/door/frame" and "matrix" in one]
    matrix = np.array(frame["matrix"]).reshape(4, 4).T
    np.testing.assert_allclose(matrix[:3, :3], rotation_body_to_world([0.0, 0.0, yaw]), atol=1e-6)
