"""Settings of the vehicle's links: as a whole, and single ones by name, such as `servos.baud_rate` or `mocap.sender`."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar, get_type_hints

import numpy as np
from numpy.typing import ArrayLike
from pydantic import TypeAdapter, ValidationError

from doorman.arrays import Array
from doorman.checks import Range, check_fields
from doorman.door_sensor.config import CAMERAS, PROGRAM
from doorman.exceptions import BackendError
from doorman.hardware.door import DoorSensorConfig, LeafGeometry
from doorman.hardware.dynamixel import ServoConfig
from doorman.hardware.mocap import MocapConfig
from doorman.hardware.pixhawk import PixhawkConfig, Rates
from doorman.hardware.pixhawk.thrust.tilted_rotors import TiltedRotors
from doorman.hardware.vehicle import gripper
from doorman.kinematics.vehicles.rotor_layout import rotor_layout
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model

GIVEN = frozenset(
    {
        "pixhawk.mocap", "pixhawk.listen_only", "pixhawk.on_mocap_loss", "pixhawk.rotors", "servos.gripper",
        "servos.lower_limits", "servos.upper_limits", "servos.rate_limits", "door_sensor.motion",
    }
)  # fmt: skip
"""What follows from the scenario and from the links themselves."""
Config = TypeVar("Config")


def with_settings(config: Config, settings: Mapping[str, object], prefix: str = "") -> Config:
    """A configuration with other values for some of its settings."""
    tree: dict[str, Any] = {}
    for name, value in settings.items():
        if part := next((other for other in settings if other.startswith(f"{name}.")), ""):
            raise BackendError(f"set twice: as a whole, and in part as {part}", field=name, given=value)
        *path, last = name.split(".")
        branch = tree
        for part in path:
            branch = branch.setdefault(part, {})
        branch[last] = value
    return _changed(config, tree, prefix)


def _changed(config: Config, tree: Mapping[str, Any], prefix: str) -> Config:
    fields = [one.name for one in dataclasses.fields(config) if one.init]  # type: ignore[arg-type]
    hints, values = get_type_hints(type(config)), {}
    for name, value in tree.items():
        field = f"{prefix}{name}"
        if name not in fields:
            raise BackendError("no such setting", field=field, allowed=", ".join(fields))
        if field in GIVEN:
            raise BackendError(
                "cannot be set: doorman derives it from the scenario and the links", field=field, given=value
            )
        current = getattr(config, name)
        if current is None and not prefix:
            raise BackendError("there is no such link", field=field, given=value)
        if isinstance(value, Mapping) and dataclasses.is_dataclass(current):
            values[name] = _changed(current, value, f"{field}.")
        elif hints[name] == ArrayLike:
            values[name] = value
        else:
            values[name] = _of_type(hints[name], value, field)
    return dataclasses.replace(config, **values)  # type: ignore[type-var]


def _of_type(hint: Any, value: object, field: str) -> Any:
    try:
        return TypeAdapter(hint).validate_python(value)
    except ValidationError as error:
        words = "; ".join(dict.fromkeys(one["msg"] for one in error.errors()))
        raise BackendError("wrong value", field=field, given=value, allowed=words) from error


DOOR_SENSOR = "door_sensor"
"""Table of the sensor of the door."""
_USUAL_CAMERAS = Range(40.0, 2000.0, "1/s")
"""Frames per second that the usual settings of poses fit."""


@dataclass(frozen=True)
class VehicleConfig:
    """Links, and how the controller is served.

    Raises:
        BackendError: if a value is out of range, or the links contradict each other.
    """

    pixhawk: PixhawkConfig
    servos: ServoConfig
    mocap: MocapConfig | None = None
    """None: the autopilot's own estimate is flown on."""
    rate: Annotated[float, Range(20.0, 1000.0, "1/s")] = 200.0
    """Ticks of the controller [1/s]."""
    door_sensor: DoorSensorConfig | None = None
    """None: nothing measures the door."""
    servo_patience: Annotated[float, Range(0.01, 1.0, "s")] = 0.3
    """Age up to which joint angles are used; the arm stands still from `servos.stale_after` on [s]."""

    def __post_init__(self) -> None:
        check_fields(self, "vehicle.")
        if self.pixhawk.mocap is not (self.mocap is not None):
            raise BackendError("pixhawk.mocap must say whether there is motion capture", field="pixhawk.mocap",
                               given=self.pixhawk.mocap, allowed=str(self.mocap is not None))  # fmt: skip
        if self.mocap is None and self.door_sensor is not None and self.door_sensor.source == CAMERAS:
            raise BackendError("there are no cameras", field="door_sensor.source", given=CAMERAS,
                               allowed="a vehicle whose poses come from cameras")  # fmt: skip

    @property
    def n_arm(self) -> int:
        """Number of the arm's joints."""
        return self.servos.n_joints

    @property
    def gripper(self) -> bool:
        """Whether the last servo is a gripper's."""
        return self.servos.gripper


def vehicle_config(
    model: Model,
    pixhawk: str,
    servos: str,
    mocap: str | None = None,
    *,
    on_mocap_loss: Literal["land", "report"] = "land",
    links: Mapping[str, object] | None = None,
) -> VehicleConfig:
    """Configuration of a scenario's vehicle with the usual settings; where the scenario grips, a gripper is the last servo.

    Args:
        model: Model of the scenario: weight, limits of the joints, kind of contact.
        pixhawk: Connection to the autopilot, such as `udp:14540`.
        servos: Serial device of the arm.
        mocap: Where the cameras' stream is received, such as `udp:51001`; None flies on the autopilot's own estimate.
        on_mocap_loss: Whether the link to the autopilot lands the vehicle where it is when poses end; "report" where a
            `Supervisor` acts on it.
        links: Any other field of the configuration by its dotted name, such as `pixhawk.setpoints` or `servos.directions`.

    Returns:
        The configuration.

    Raises:
        BackendError: if a value is out of range, or a joint of the arm slides.
    """
    settings = dict(links or {})
    vehicle, grips = model.vehicle, model.scenario.contact.kind == "grip"
    lower, upper, rates = servo_limits(vehicle)
    if grips:
        lower, upper = np.append(lower, gripper.LOWER), np.append(upper, gripper.UPPER)
        rates = np.append(rates, gripper.RATE)
    ids: Any = settings.pop("servos.ids", range(1, len(lower) + 1))
    if len(ids) != len(lower):
        order = "of the joints from base to tip, then of the gripper" if grips else "of the joints from base to tip"
        raise BackendError("wrong number of ids", field="servos.ids", given=tuple(ids),
                           allowed=f"{len(lower)} ids, {order}")  # fmt: skip
    frames = settings.get("mocap.rate", MocapConfig.rate)
    if mocap is not None and "mocap.stale_after" not in settings and isinstance(frames, float | int):
        if not _USUAL_CAMERAS.holds(frames):
            raise BackendError("out of range", field="mocap.rate", given=frames, allowed=str(_USUAL_CAMERAS))
    config = VehicleConfig(
        pixhawk=PixhawkConfig(
            pixhawk, mocap=mocap is not None, hover_force=vehicle.weight, rates=Rates(setpoint=VehicleConfig.rate),
            on_mocap_loss=on_mocap_loss, min_battery=model.scenario.safety.low_battery, rotors=_tilted_rotors(model),
        ),
        servos=ServoConfig(
            servos, lower, upper, rates, ids=tuple(ids), gripper=grips, latency=0.006, stale_after=0.05,
        ),
        mocap=None if mocap is None else MocapConfig("vehicle", mocap, stale_after=0.04, prediction_limit=0.2),
        door_sensor=_door_sensor(model, settings),
    )  # fmt: skip
    return with_settings(
        config, {key: value for key, value in settings.items() if key.partition(".")[0] != DOOR_SENSOR}
    )


def _door_sensor(model: Model, links: Mapping[str, object]) -> DoorSensorConfig | None:
    """Sensor of the door, where anything is said of it."""
    prefix, whole = f"{DOOR_SENSOR}.", links.get(DOOR_SENSOR)
    given = {str(key): value for key, value in whole.items()} if isinstance(whole, Mapping) else {}
    given |= {key.removeprefix(prefix): value for key, value in links.items() if key.startswith(prefix)}
    if not given:
        return None
    found = DoorSensorConfig(source=PROGRAM, motion=LeafGeometry.of(model.door))
    return with_settings(found, {"source": CAMERAS, **given}, prefix)


def _tilted_rotors(model: Model) -> TiltedRotors | None:
    """Rotors of a fully actuated vehicle; None for any other."""
    if not model.actuation.fully:
        return None
    return TiltedRotors.of(rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust))


def servo_limits(vehicle: Vehicle) -> tuple[Array, Array, Array]:
    """Limits of the arm's servos; one of a continuous joint turns once, as its ticks count no further."""
    if vehicle.slides.any():
        raise BackendError("a servo cannot drive a prismatic joint", file=vehicle.urdf, given="prismatic",
                           field=f"joint {vehicle.joint_names[int(vehicle.slides.argmax())]}",
                           allowed="revolute, continuous")  # fmt: skip
    lower, upper = vehicle.lower_limits, vehicle.upper_limits
    ends = np.where(np.isfinite(lower), lower, -math.pi), np.where(np.isfinite(upper), upper, math.pi)
    return *ends, vehicle.rate_limits
