"""What a mission writes down: phases, and each tick in the map's frame, wherever the door is believed to stand."""

from __future__ import annotations

import time
from operator import attrgetter

import numpy as np

from doorman.control.estimation.door_locator import DoorLocator
from doorman.control.estimation.door_watch import DoorWatch
from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint, Thrust
from doorman.model import Model
from doorman.recording import Recorder
from doorman.signals import Command, LeafReading, Measurement

_MEASUREMENT_FIELDS = ("position", "velocity", "attitude", "body_rates", "arm_angles", "arm_rates", "pose_time")
_measured = attrgetter(*_MEASUREMENT_FIELDS)


class FlightLog:
    """Topics of one mission.

    Args:
        model: Model of the scenario.
        recorder: Where they go.
        locator: From where the mission sees the door to the map.
        watch: What the door's sensors are found to do.
    """

    def __init__(self, model: Model, recorder: Recorder, locator: DoorLocator, watch: DoorWatch) -> None:
        self._model, self._recorder, self._locator, self._watch = model, recorder, locator, watch
        self._started = time.perf_counter()

    def begin(self) -> None:
        """The flight begins: wall time counts from here."""
        self._started = time.perf_counter()

    def phase(self, now: float, phase: str, message: str) -> None:
        """A phase begins."""
        wall_time = time.perf_counter() - self._started
        self._recorder.write("mission", now, {"state": phase, "message": message, "wall_time": wall_time})

    def tick(
        self, measurement: Measurement, estimate: Estimate, setpoint: Setpoint, thrust: Thrust, command: Command
    ) -> None:
        """One tick, in the map."""
        now, write, hinge, door = measurement.time, self._recorder.write, estimate.hinge, self._locator
        state = estimate.state.copy()
        state[2] = door.heading(estimate.yaw)
        velocity, wind, tip_force, moves, gains, presses = door.vectors(
            estimate.velocity, estimate.wind, estimate.tip_force, setpoint.velocity, setpoint.acceleration, setpoint.force
        )  # fmt: skip
        write("measurement", now, dict(zip(_MEASUREMENT_FIELDS, _measured(measurement), strict=True)))
        if measurement.tip_force is not None:
            write("tip_sensor", now, {"force": measurement.tip_force})
        write(
            "estimate",
            now,
            {
                "state": state,
                "door_disturbance": estimate.door_disturbance,
                "position": door.place(estimate.position),
                "velocity": velocity,
                "wind": wind,
                "tip_force": tip_force,
                "normal_force": estimate.normal_force,
                "touching": estimate.touching,
                "hinge": np.array((hinge.damping, hinge.friction, hinge.stiffness, hinge.inertia)),
                "door_place": door.state,
                "door_place_deviation": door.deviations,
                "door_angle_deviation": door.angle_deviation(estimate.door_angle),
                "torque_deviation": hinge.torque_deviation,
                "hinge_deviation": np.array((
                    hinge.damping_deviation, hinge.friction_deviation, hinge.stiffness_deviation, hinge.inertia_deviation
                )),
            },
        )  # fmt: skip
        write(
            "setpoint",
            now,
            {
                "position": door.place(setpoint.position),
                "velocity": moves,
                "acceleration": gains,
                "force": presses,
                "yaw": door.heading(setpoint.yaw),
                "arm_rates": setpoint.arm_rates,
            },
        )
        write("command", now, vars(command))
        write(
            "controller",
            now,
            {"disturbance": thrust.disturbance, "force": thrust.force, "saturated": thrust.saturated},
        )

    def door(self, measured: Measurement, leaf: LeafReading | None) -> None:
        """What a sensor of the door says, and whether it is believed."""
        now, write, frame = measured.time, self._recorder.write, measured.frame
        if leaf is not None:
            write(
                "door_sensor", now,
                {
                    "joint": leaf.joint, "door_angle": self._model.door.angle_of_joint(leaf.joint), "leaf_time": leaf.time,
                    "deviation": leaf.deviation, "believed": measured.leaf is not None,
                },
            )  # fmt: skip
        if frame is not None:
            write("door_frame", now, {"position": frame.position, "yaw": frame.yaw, "frame_time": frame.time})
        for time_of, words in self._watch.messages:
            write("event", time_of, {"source": "door sensor", "message": words})
        self._watch.messages.clear()
