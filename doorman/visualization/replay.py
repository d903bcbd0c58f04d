"""Replay page: one HTML file that shows a recorded flight in three dimensions, and needs neither server nor network.

The page holds meshcat's viewer and meshcat's commands. They are written here rather than by `meshcat.Visualizer`, which
would start a server in a process of its own only to hand the same commands back.
"""

from __future__ import annotations

import html
import importlib.util
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import DoormanError, RecordingError
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.meshcat_scene import FRAMES_PER_SECOND, Command, Scene, set_property
from doorman.visualization.shapes import VisualShape, visual_shapes

Array = NDArray[np.float64]

_ROTOR_RATE = 9.0
"""Slow enough to see the rotors turn [rad/s]."""
_DISC_COLOR = (0.0, 0.45, 0.70, 0.10)
_ZOOM = 2.4
_SKY = [0.93, 0.95, 0.97]


@dataclass(frozen=True)
class _Motion:
    """What moves, at the frames of the page."""

    start: float
    vehicle: Array
    """Placements of the body in the world, shape (m, 4, 4)."""
    door_angle: Array
    """Shape (m,) [rad]."""
    arm_angles: Array
    """Shape (m, n) [rad]."""
    tip: Array
    """Shape (m, 3), world frame [m]."""


def replay_page(recording: Recording, model: Model, path: str | Path) -> Path:
    """Write a page that replays a recording.

    What is shown is the simulator's truth if the recording has it, else what was measured and estimated. Times with a value
    that is not finite are left out.

    Args:
        recording: With topic `truth`, or with `measurement` and `estimate`.
        model: Model of the scenario that was flown.
        path: HTML file to write.

    Returns:
        The path.

    Raises:
        RecordingError: if the recording holds no motion.
        DoormanError: if meshcat is not installed.
        OSError: if the file cannot be written.
    """
    template = Template(Path(__file__).with_name("replay.html").read_text(encoding="utf-8"))
    title = html.escape(f"doorman: {recording.header.get('name', 'replay')}")
    scene = json.dumps(_scene(_motion(recording, model), model), allow_nan=False, separators=(",", ":"))
    page = template.substitute(title=title, viewer=_viewer_source(), replay=scene.replace("</", "<\\/"))
    path = Path(path)
    path.write_text(page, encoding="utf-8")
    return path


def _viewer_source() -> str:
    """The viewer as one script; the package is not imported, for it would bring its server along."""
    package = importlib.util.find_spec("meshcat")
    for folder in (package.submodule_search_locations or []) if package is not None else []:
        file = Path(folder) / "viewer" / "dist" / "main.min.js"
        if file.is_file():
            return file.read_text(encoding="utf-8")
    raise DoormanError("the replay page needs meshcat", field="meshcat", allowed="pip install 'doorman[viz]'")


def _motion(recording: Recording, model: Model) -> _Motion:
    """Resample to the frames of the page."""
    source = "truth" if "truth" in recording else "measurement"
    if source not in recording or (source == "measurement" and "estimate" not in recording):
        raise RecordingError(
            "no motion to replay", field="recording", given=", ".join(recording) or "no topic",
            allowed="topic truth, or measurement and estimate",
        )  # fmt: skip
    topic = recording[source]
    if source == "truth":
        angle = topic["door_angle"]
    else:
        angle = np.interp(topic.time, recording["estimate"].time, recording["estimate"]["state"][:, 3])
    rows = np.column_stack([topic["position"], topic["attitude"], angle, topic["arm_angles"]])
    good = np.isfinite(rows).all(axis=1)
    if not good.any():
        raise RecordingError("no finite motion to replay", field=source)
    time, rows = topic.time[good], rows[good]
    rows[:, 3:6] = np.unwrap(rows[:, 3:6], axis=0)
    frames = time[0] + np.arange(int((time[-1] - time[0]) * FRAMES_PER_SECOND) + 1) / FRAMES_PER_SECOND
    rows = np.column_stack([np.interp(frames, time, column) for column in rows.T])
    vehicle = np.tile(np.eye(4), (len(frames), 1, 1))
    vehicle[:, :3, :3] = [rotation_body_to_world(attitude) for attitude in rows[:, 3:6]]
    vehicle[:, :3, 3] = rows[:, :3]
    in_body = np.array([model.vehicle.tip_position(arm) for arm in rows[:, 7:]])
    tip = np.einsum("mij,mj->mi", vehicle[:, :3, :3], in_body) + rows[:, :3]
    return _Motion(float(time[0]), vehicle, rows[:, 6], rows[:, 7:], tip)


def _scene(motion: _Motion, model: Model) -> Command:
    """Everything that the page's script needs."""
    scene = Scene(len(motion.door_angle))
    vehicle = [model.vehicle.link_placements(arm) for arm in motion.arm_angles]
    door = [model.door.link_placements(angle) for angle in motion.door_angle]
    scene.move("/scene/vehicle", motion.vehicle)
    rotors = _rotors(model, vehicle[0])
    for group, urdf, placements in (("vehicle", model.vehicle.urdf, vehicle), ("door", model.door.urdf, door)):
        shapes = visual_shapes(urdf)
        for link in dict.fromkeys(shape.link for shape in shapes):
            scene.move(f"/scene/{group}/{link}", np.array([placement[link] for placement in placements]))
        for index, shape in enumerate(shapes):
            turning = "/turning" if group == "vehicle" and shape.link in rotors else ""
            scene.add(f"/scene/{group}/{shape.link}{turning}/shape_{index}", shape)
    disc = VisualShape("", "cylinder", (model.vehicle.radius, 0.001), np.eye(4), _DISC_COLOR)
    scene.add(f"/scene/vehicle/{model.vehicle.names.base_link}/disc", disc)
    trace = scene.trace("/scene/trace", motion.tip)
    scene.commands += _surroundings()
    scene.commands.append(scene.animation())
    return {
        "commands": scene.commands,
        "fps": FRAMES_PER_SECOND,
        "start": round(motion.start, 3),
        "door_angle": np.degrees(motion.door_angle).round(2).tolist(),
        "rotors": [(f"scene/vehicle/{link}/turning", direction) for link, direction in rotors.items()],
        "rotor_rate": _ROTOR_RATE,
        "camera": _camera(model),
        "trace": trace,
        "trace_path": "scene/trace",
    }


def _rotors(model: Model, placements: Mapping[str, Array]) -> dict[str, float]:
    """Sense of rotation by link, for the links that sit where the vehicle has rotors."""
    return {
        link: rotor.direction
        for rotor in model.vehicle.rotors
        for link, placement in placements.items()
        if np.allclose(placement[:3, 3], rotor.position, atol=1e-9)
    }


def _surroundings() -> list[Command]:
    return [
        set_property("/Grid", "visible", False),
        set_property("/Axes", "visible", False),
        set_property("/Background", "top_color", _SKY),
        set_property("/Background", "bottom_color", _SKY),
        set_property("/Lights/AmbientLight/<object>", "intensity", 0.75),
        set_property("/Lights/PointLightNegativeX/<object>", "intensity", 0.2),
        set_property("/Lights/PointLightPositiveX/<object>", "intensity", 0.2),
        set_property("/Cameras/default/rotated/<object>", "zoom", _ZOOM),
    ]


def _camera(model: Model) -> dict[str, list[float]]:
    """Eye and target of the camera: from the vehicle's side, a little above, on the doorway."""
    width = model.door.width
    target = model.door.hinge_position + [0.2, 0.5 * width, 0.95 * model.scenario.contact.height]
    eye = target + width * np.array([-2.45, 1.5, 0.4])
    y_up = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # the camera's own frame
    return {"eye": (y_up @ eye).round(3).tolist(), "target": (y_up @ target).round(3).tolist()}
