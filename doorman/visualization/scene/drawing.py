"""Drawing of a flight as data for the page: what stands still once, and one small frame per moment for what moves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.visualization.scene.moments import FRAMES_PER_SECOND, Moment
from doorman.visualization.scene.page import Y_TO_Z, Command, place, set_property, show
from doorman.visualization.scene.shapes import visual_shapes
from doorman.visualization.scene.surfaces import SURFACES, clearances, surface_shapes


class Drawing:
    def __init__(self, model: Model) -> None:
        self._model = model
        self._shapes = {
            "vehicle": visual_shapes(model.vehicle.urdf),
            "door": visual_shapes(model.true_door.urdf),
        }
        drawn = {f"/scene/{group}/{shape.link}" for group, shapes in self._shapes.items() for shape in shapes}
        self._still, moved = (  # between which everything moves that can
            self._placements(np.full(3, value), np.full(3, value), value, model.start_arm + value)
            for value in (0.0, 0.1)
        )
        self._nodes = [
            node
            for node, placement in self._still.items()
            if node in {*drawn, "/scene/vehicle"} and not np.allclose(placement, moved[node], atol=1e-12)
        ]
        arm = model.vehicle.link_placements(model.start_arm)
        self._rotors = {  # sense of rotation by link, for the links that sit where the vehicle has rotors
            link: rotor.direction
            for rotor in model.vehicle.rotors
            for link, placement in arm.items()
            if np.allclose(placement[:3, 3], rotor.position, atol=1e-9)
        }

    def scene(self) -> Command:
        """Everything that a page needs to know before the first frame."""
        model = self._model
        surfaces = surface_shapes(model)
        sun = np.array([-0.55, 0.25, 0.8])  # its light casts shadows; x leads through the doorway
        return {
            "commands": [*self._commands(), *_surroundings()],
            "fps": FRAMES_PER_SECOND,
            "nodes": [node.strip("/") for node in self._nodes],
            "surfaces": [
                {"node": node.strip("/"), "name": name} for node, name in zip(surfaces, SURFACES, strict=True)
            ],
            "rotors": [
                (f"scene/vehicle/{link}/turning", direction) for link, direction in self._rotors.items()
            ],
            "rotor_rate": 9.0,  # [rad/s]; slow enough to see the rotors turn
            "camera": _camera(model),
            "sun": model.door.from_doorway(sun).round(3).tolist(),
            "goal": round(float(np.degrees(model.goal_angle)), 2),
            "margin": model.scenario.planner.margin,
        }  # fmt: skip

    def frame(self, moment: Moment) -> dict[str, Any]:
        model = self._model
        placements = self._placements(moment.position, moment.attitude, moment.door_angle, moment.arm_angles)
        body = placements["/scene/vehicle"]
        tip = body[:3, :3] @ model.vehicle.tip_position(moment.arm_angles) + moment.position
        force = moment.tip_force
        return {
            "time": round(moment.time, 4),
            "poses": [_pose(placements[node]) for node in self._nodes],
            "door_angle": round(float(np.degrees(moment.door_angle)), 2),
            "clearances": clearances(model, moment).round(4).tolist(),
            "tip": tip.round(4).tolist(),
            "force": force.round(3).tolist() if force is not None and np.isfinite(force).all() else None,
            "ribbon": None if moment.planned_states is None else self._ribbon(moment.planned_states),
            "phase": moment.phase,
            "reason": moment.reason,
        }

    def _placements(self, position: Array, attitude: Array, door_angle: float, arm_angles: Array) -> dict[str, Array]:
        """Placement of every node in its parent."""
        body = np.eye(4)
        body[:3, :3], body[:3, 3] = rotation_body_to_world(attitude), position
        arm = self._model.vehicle.link_placements(arm_angles)
        door = self._model.true_door.link_placements(door_angle)
        return {
            "/scene/vehicle": body,
            **{f"/scene/vehicle/{link}": placement for link, placement in arm.items()},
            **{f"/scene/door/{link}": placement for link, placement in door.items()},
        }

    def _commands(self) -> list[Command]:
        commands = [place(node, placement) for node, placement in self._still.items() if node not in self._nodes]
        for group, shapes in self._shapes.items():
            for index, shape in enumerate(shapes):
                turning = "/turning" if group == "vehicle" and shape.link in self._rotors else ""
                commands += show(f"/scene/{group}/{shape.link}{turning}/shape_{index}", shape)
        for node, shape in surface_shapes(self._model).items():
            commands += show(node, shape)
        return commands

    def _ribbon(self, states: Array, count: int = 18, width: float = 0.05) -> list[list[float]] | None:
        """Lower and upper edge of the vehicle's planned path, as rows of six coordinates, at some nodes of the plan."""
        nodes = np.unique(np.linspace(0, len(states) - 1, count).astype(int))
        if not np.isfinite(states[nodes]).all():
            return None
        rows = []
        for state in states[nodes]:
            middle = self._model.coupling.vehicle_position(state[:3], state[3], state[5:])
            up = 0.5 * width * rotation_body_to_world(state[:3])[:, 2]
            rows.append([*(middle - up).round(3).tolist(), *(middle + up).round(3).tolist()])
        return rows


def _pose(placement: Array) -> list[float]:
    """Position and quaternion (x, y, z, w)."""
    quaternion = pinocchio.Quaternion(placement[:3, :3]).coeffs()
    return [*placement[:3, 3].round(4).tolist(), *quaternion.round(5).tolist()]


def _surroundings() -> list[Command]:
    sky = [0.93, 0.95, 0.97]
    return [
        set_property("/Grid", "visible", False),
        set_property("/Axes", "visible", False),
        set_property("/Background", "top_color", sky),
        set_property("/Background", "bottom_color", sky),
        set_property("/Lights/AmbientLight/<object>", "intensity", 0.55),
        set_property("/Lights/PointLightNegativeX/<object>", "intensity", 0.2),
        set_property("/Lights/PointLightPositiveX/<object>", "intensity", 0.2),
        set_property("/Cameras/default/rotated/<object>", "zoom", 2.4),
    ]


def _camera(model: Model) -> dict[str, list[float]]:
    """Eye and target of the camera: from the vehicle's side, a little above, on the doorway, or on what moves before the wall."""
    door, start = model.door, model.start_state
    contact = model.coupling.contact_point(float(start[3]))
    vehicle = model.coupling.vehicle_position(start[:3], float(start[3]), start[5:])
    ahead = np.array([*(contact - vehicle)[:2], 0.0])
    ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
    aside = np.array([-ahead[1], ahead[0], 0.0])
    aside *= math.copysign(1.0, float(aside @ door.along))
    target = contact + (0.2 if door.side == "push" else -0.3) * ahead  # where it pulls, before the wall
    target[2] *= 0.95
    eye = target + max(door.width, 1.1) * (-2.45 * ahead + 1.5 * aside + np.array([0.0, 0.0, 0.4]))
    y_up = Y_TO_Z[:3, :3].T  # the camera's own frame
    return {"eye": (y_up @ eye).round(3).tolist(), "target": (y_up @ target).round(3).tolist()}
