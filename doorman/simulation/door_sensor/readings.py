"""The sensor of a simulated flight, of the kind that the scenario names."""

from __future__ import annotations

from collections.abc import Callable

from doorman.door_sensor.printing import usual_camera, usual_marks
from doorman.signals import FrameReading, LeafReading
from doorman.simulation.door_sensor.simulated import SimulatedDoorSensor
from doorman.simulation.door_sensor.view import TagView
from doorman.simulation.plant.engine import engine
from doorman.simulation.simulator import Simulator
from doorman.simulation.truth import Truth

DoorReadings = Callable[[Truth], tuple[LeafReading | None, FrameReading | None]]
"""What a sensor of the door says at every tick, leaf and frame; none where it has nothing to say."""


def door_readings(simulator: Simulator, seed: int) -> DoorReadings:
    """The sensor that `[simulation.door_sensor]` names."""
    model = simulator.model
    section = model.scenario.simulation.door_sensor
    if section.kind in ("cameras", "encoder"):
        return SimulatedDoorSensor(model, seed).measure
    mujoco, plant = engine(), simulator.plant
    marks, camera = usual_marks(model, section.tag_size), usual_camera(section.field_of_view)
    if section.kind == "tags":
        return SimulatedDoorSensor(model, seed, TagView(mujoco, plant, marks, camera)).measure
    from doorman.simulation.door_sensor.pictures import PictureSensor

    pictures, timing = (
        PictureSensor(mujoco, simulator, marks, camera, seed),
        SimulatedDoorSensor(model, seed),
    )

    def readings(truth: Truth) -> tuple[LeafReading | None, FrameReading | None]:
        if timing.due(truth.time):
            timing.take(truth.time, *pictures.look(truth.time, truth.position, truth.attitude))
        return timing.arrived(truth.time)

    return readings
