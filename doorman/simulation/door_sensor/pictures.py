"""Pictures of the vehicle's camera, rendered by MuJoCo, and what the real detector and `DoorSensor` make of them.

Rendering off screen needs EGL: on Debian and Ubuntu the packages libegl1 and libgl1. Tags are sites with a texture: they touch
nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.door_sensor.config import CameraConfig, DoorSensorConfig, LeafGeometry, Mark
from doorman.door_sensor.detector import DoorByTags, SeenTag, TagDetector, opencv
from doorman.door_sensor.printing import tag_cells
from doorman.door_sensor.sensor import CallableSource, DoorSample, DoorSensor
from doorman.exceptions import BackendError
from doorman.kinematics.quaternions import multiply
from doorman.kinematics.rotations import quaternion_of
from doorman.kinematics.urdf.elements import link_name
from doorman.kinematics.vehicles.rotor_layout import RotorLayout
from doorman.model import Model
from doorman.signals import FrameReading, LeafReading
from doorman.simulation.plant.assembly import DOOR, VEHICLE, assemble
from doorman.simulation.simulator import Simulator

CAMERA = "vehicle camera"
_GROUP = 3
"""Group of the sites that are drawn."""
_CELL = 32
"""Pixels of a tag's cell in its texture."""
_THIN = 2e-4
"""Half of a sheet's thickness [m]."""
_MOST_SHAPES = 2000
"""Most shapes of a scene."""
_LENS = (0.5, 0.5, -0.5, -0.5)
"""Quaternion from a camera of MuJoCo (right, up, back) to one that looks along x."""
_BLUR, _NOISE = 0.8, 4.0
"""Blur of the lens [pixel] and noise of the sensor [grey levels]."""


def scene_with_tags(
    mujoco: Any, model: Model, layout: RotorLayout, time_step: float, marks: tuple[Mark, Mark], camera: CameraConfig
) -> Any:
    """The plant once more, for pictures alone: with tags on leaf and frame, and a camera on the vehicle."""
    spec, door, names = assemble(mujoco, model, layout, time_step), model.true_door, model.vehicle.names
    leaf, world = spec.body(DOOR + link_name(door.urdf, door.section.leaf)), spec.worldbody
    base, placed = spec.body(VEHICLE + link_name(model.vehicle.urdf, names.base_link)), door.placement
    spec.visual.global_.offwidth, spec.visual.global_.offheight = camera.width, camera.height
    for body, mark in ((leaf, marks[0]), (world, marks[1])):
        name = f"tag {mark.name}"
        sheet = np.kron(np.pad(~tag_cells(mark.tag), 1, constant_values=True), np.ones((_CELL, _CELL))) * 255
        picture = np.repeat(sheet.astype(np.uint8)[:, :, None], 3, axis=2)
        flat, size = mujoco.mjtTexture.mjTEXTURE_2D, sheet.shape[0]
        texture = spec.add_texture(name=name, type=flat, width=size, height=size, nchannel=3)
        texture.data = picture.tobytes()
        material = spec.add_material(name=name, texuniform=False)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
        half = 0.5 * mark.size * 10.0 / 8.0
        position, turn = np.array(mark.position), quaternion_of(mark.attitude)
        if body is world:
            position = (placed @ [*position, 1.0])[:3]
            yaw = np.arctan2(placed[1, 0], placed[0, 0])
            turn = multiply(quaternion_of((0.0, 0.0, float(yaw))), turn)
        body.add_site(name=name, type=mujoco.mjtGeom.mjGEOM_BOX, size=[half, half, _THIN], pos=position, quat=turn,
                      material=name, group=_GROUP, rgba=[1, 1, 1, 1])  # fmt: skip
    looks = multiply(quaternion_of(camera.attitude), _LENS)
    fov = np.degrees(2.0 * np.arctan(0.5 * camera.height / camera.fy))
    base.add_camera(name=CAMERA, pos=camera.position, quat=looks, fovy=fov)
    spec.worldbody.add_light(pos=[-2.0, 0.0, 3.0], dir=[1.0, 0.0, -1.0], diffuse=[0.7, 0.7, 0.7])
    return spec.compile()


class PictureSensor:
    """The real detector on rendered pictures."""

    def __init__(
        self, mujoco: Any, simulator: Simulator, marks: tuple[Mark, Mark], camera: CameraConfig, seed: int
    ) -> None:
        model, self._plant = simulator.model, simulator.plant
        compiled = scene_with_tags(mujoco, model, simulator.layout, simulator.time_step, marks, camera)
        self._data = mujoco.MjData(compiled)
        self._mujoco, self._compiled, self._camera = mujoco, compiled, camera
        try:
            from mujoco.egl import GLContext  # whatever MUJOCO_GL says: the screen is of no use here

            self._context = GLContext(camera.width, camera.height)
            self._context.make_current()
            self._drawn = mujoco.MjrContext(compiled, mujoco.mjtFontScale.mjFONTSCALE_100)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawn)
            self._scene = mujoco.MjvScene(compiled, _MOST_SHAPES)
        except Exception as error:  # of OpenGL, and whatever stands behind it
            raise BackendError(
                f"cannot render off screen: {error}", field="simulation.door_sensor.kind", given="pictures",
                allowed="a system with EGL (Debian and Ubuntu: apt install libegl1 libgl1), or another kind",
            ) from error  # fmt: skip
        self._option = mujoco.MjvOption()
        self._option.sitegroup[:] = 0
        self._option.sitegroup[_GROUP] = 1
        self._cv, self._noise = opencv(), np.random.default_rng([seed, 9])
        self._detector = TagDetector(camera, {mark.tag: mark.size for mark in marks})
        motion = LeafGeometry.of(model.door)
        config = DoorSensorConfig(source="tags", leaf=marks[0], frame=marks[1], camera=camera, motion=motion)
        self._door, self._sample = DoorByTags(config), DoorSample()
        self._sensor = DoorSensor(CallableSource(lambda: self._sample), config)
        self.seen: dict[int, SeenTag] = {}  # tags of the last picture

    def picture(self) -> NDArray[np.uint8]:
        """What the camera sees now, with blur and noise, grey, shape (height, width)."""
        grey = self._cv.cvtColor(self.colours(), self._cv.COLOR_RGB2GRAY)
        grey = self._cv.GaussianBlur(grey, (0, 0), _BLUR) + _NOISE * self._noise.normal(size=grey.shape)
        return np.asarray(np.clip(grey, 0, 255).astype(np.uint8))

    def colours(self) -> NDArray[np.uint8]:
        """The same without blur and noise, in colours, shape (height, width, 3)."""
        mujoco, camera = self._mujoco, self._mujoco.MjvCamera()
        camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, self._compiled.camera(CAMERA).id
        self._context.make_current()
        everything = mujoco.mjtCatBit.mjCAT_ALL
        self._data.qpos[:] = self._plant.data.qpos
        mujoco.mj_kinematics(self._compiled, self._data)
        mujoco.mj_camlight(self._compiled, self._data)
        mujoco.mjv_updateScene(self._compiled, self._data, self._option, None, camera, everything, self._scene)
        area = mujoco.MjrRect(0, 0, self._camera.width, self._camera.height)
        mujoco.mjr_render(area, self._scene, self._drawn)
        picture = np.zeros((self._camera.height, self._camera.width, 3), np.uint8)
        mujoco.mjr_readPixels(picture, None, area, self._drawn)
        return np.asarray(picture[::-1])

    def look(
        self, time: float, position: NDArray[np.float64], attitude: NDArray[np.float64]
    ) -> tuple[LeafReading | None, FrameReading | None]:
        """What a picture of now says, with the pose that the vehicle believes to have."""
        self.seen = self._detector.detect(self.picture())
        self._sample = self._door.sample(time, {number: tag.pose for number, tag in self.seen.items()}, DoorSample())
        self._sensor.note_pose(time, position, attitude)
        return self._sensor.read(time)

    def close(self) -> None:
        """Let go of the renderer."""
        self._drawn.free()
        self._context.free()
