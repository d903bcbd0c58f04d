"""The whole rig: emulated autopilot, servos and cameras around one plant, on loopback and a pseudo-terminal."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal, cast

from doorman.background import Opened
from doorman.clocks import REAL_TIME, Clock
from doorman.door_sensor.config import CAMERAS
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import ServoConfig
from doorman.hardware.dynamixel.registers import BAUD_CODES
from doorman.hardware.mocap import MocapConfig
from doorman.hardware.mocap.connection import LOOPBACK
from doorman.hardware.pixhawk import PixhawkConfig
from doorman.hardware.pixhawk.dialect import ARDUPILOT
from doorman.hardware.pixhawk.wire.codec import load_key
from doorman.hardware.vehicle import VehicleConfig, vehicle_config
from doorman.kinematics.vehicles.rotor_layout import rotor_layout
from doorman.model import Model
from doorman.recording import Recorder
from doorman.rig.adapters import RigArm, RigVehicle, body_seen, frame_seen, leaf_seen
from doorman.rig.emulators.autopilot import EmulatedAutopilot
from doorman.rig.emulators.autopilot.control import add_rotors
from doorman.rig.emulators.autopilot.dialects import DIALECTS, Flavour, MotorKind
from doorman.rig.emulators.mocap.emulator import MocapEmulator, TrackedBody, TrackerSetup
from doorman.rig.emulators.servos import ServoEmulator
from doorman.rig.emulators.servos.unit import READY, READY_TO_GRIP, ServoSetup
from doorman.rig.plant import RigPlant
from doorman.rig.sitl.ardupilot import SERVO_PORT, ArduPilotSitl
from doorman.rig.sitl.px4 import Px4Sitl, simulator_port
from doorman.rig.sitl.rotor_pilot import RotorPilot

AutopilotKind = Literal["px4", "ardupilot", "px4-sitl", "ardupilot-sitl"]
"""An emulated autopilot that follows the rules of PX4 or of ArduPilot, or the own code of one of them."""
_UNUSED_PORT = 51001
"""Port of cameras that do not send."""
SERVOS = "servos"
"""Name of the link to the pseudo-terminal."""
_SAFE = {
    "px4": {"COM_OF_LOSS_T": 0.2, "COM_OBL_RC_ACT": 3.0, "RTL_RETURN_ALT": 0.0, "RTL_CONE_ANG": 0.0, "RTL_MIN_DIST": 0.5,
            "NAV_ACC_RAD": 0.2, "MPC_YAW_MODE": 5.0, "NAV_RCL_ACT": 3.0},
    "ardupilot": {"GUID_OPTIONS": 8.0, "GUID_TIMEOUT": 0.2, "FS_GCS_ENABLE": 1.0, "FS_GCS_TIMEOUT": 2.0, "RTL_ALT": 30.0,
                  "RTL_LOIT_TIME": 0.0, "WPNAV_JERK": 5.0, "FS_OPTIONS": 24.0, "FS_THR_ENABLE": 3.0, "VISO_DELAY_MS": 6.0},
}  # fmt: skip
"""Parameters as the check of the adapter wants them: without us the vehicle flies back as high as it is, and lands on its pad."""


MOTOR_LAG = 0.04
"""Time constant of motors whose thrust is the signal squared: of propellers of 10 to 13 inches [s]."""
SPRING = 0.25
"""Current that balances the gripper's spring [A]."""


def _servo_setups(mounted: ServoConfig) -> list[ServoSetup]:
    """Servos as a vehicle's configuration says that they are mounted and set up."""
    speed = {"baud rate": BAUD_CODES[mounted.baud_rate]}
    setups = [
        ServoSetup(number, {**READY, **speed, "homing offset": offset}, zero - offset, sign)
        for number, zero, sign, offset in zip(mounted.ids, mounted.zeros, mounted.signs, mounted.offsets, strict=True)
    ]
    if mounted.gripper:
        last = setups[-1]
        last.eeprom, last.spring = {**last.eeprom, "operating mode": READY_TO_GRIP["operating mode"]}, SPRING
    return setups


def _tracker_setup(plant: RigPlant, vehicle: VehicleConfig) -> TrackerSetup:
    """Cameras, the vehicle and what is stuck on the door as a vehicle's configuration says where they are."""
    cameras, sensor = vehicle.mocap or MocapConfig("vehicle"), vehicle.door_sensor
    seen = ((sensor.leaf, leaf_seen), (sensor.frame, frame_seen)) if sensor and sensor.source == CAMERAS else ()
    return TrackerSetup(
        cameras.object_name, cameras.rate, cameras.latency,
        origin_position=cameras.origin_position, origin_attitude=cameras.origin_attitude,
        object_position=cameras.object_position, object_attitude=cameras.object_attitude,
        bodies={
            mark.name: TrackedBody(partial(look, plant), mark.position, mark.attitude)
            for mark, look in seen if mark is not None
        },
    )  # fmt: skip


@dataclass(frozen=True)
class RigSetup:
    """How the rig is wired.

    Raises:
        BackendError: if a port is out of range.
    """

    autopilot: AutopilotKind = "px4"
    """Autopilot that flies the vehicle."""
    pixhawk_port: int = 14540
    """UDP port on loopback that it sends to."""
    mocap_port: int = 51001
    """UDP port on loopback that the cameras send to; 0: there are none, and the autopilot has satellites."""
    folder: Path | None = None
    """Where the link to the servos' pseudo-terminal is made; None: a new temporary folder."""
    heartbeat_rate: float = 1.0
    """Rate of the autopilot's heartbeats [1/s]."""
    seed: int = 0
    """Seed of noise and faults."""
    vehicle: VehicleConfig | None = None
    """How servos, object and autopilot are mounted and set up; None: as the adapters expect it."""
    servos: Path | None = None
    """Link to the servos' pseudo-terminal; None: `servos` in `folder`."""
    sitl_port: int | None = None
    """Port on loopback that the autopilot's own code calls; None: the one that it calls by itself."""
    motors: MotorKind = "linear"
    """Whether the autopilot's parameters linearise the motors; else they are the factory's, and thrust lags by `MOTOR_LAG`."""

    def __post_init__(self) -> None:
        for name, least in (("pixhawk_port", 1), ("mocap_port", 0), ("sitl_port", 1)):
            value = getattr(self, name)
            if value is not None and not least <= value <= 65535:
                raise BackendError("not a port", field=name, given=value, allowed=f"{least} to 65535")
        if self.mocap_port == 0 and self.autopilot not in _SAFE:
            raise BackendError("the autopilot's own code gets no satellites from the rig", field="mocap_port", given=0,
                               allowed="1 to 65535")  # fmt: skip


class Rig(Opened):
    """Everything that `doorman fly` needs but the hardware. The constructor opens nothing; `open` does, on loopback only.

    Args:
        model: The model, for the rig alone.
        setup: Ports and kinds.
        recorder: Gets the truth.
        clock: Clock of everything in it.
    """

    def __init__(
        self, model: Model, setup: RigSetup | None = None, recorder: Recorder | None = None, clock: Clock = REAL_TIME
    ) -> None:
        self.model = model
        self.setup = setup or RigSetup()
        self.pilot = self._own_code()
        """The autopilot's own code; None where it is emulated."""
        motor_lag = MOTOR_LAG if self.setup.motors == "quadratic" else 0.0
        feedback = ARDUPILOT.feedback_lag if self.setup.autopilot == "ardupilot" else 0.0
        self.plant = RigPlant(model, recorder, self.pilot, motor_lag, feedback, clock)
        self._folder = self.setup.folder or self._temporary_folder()
        self._servos = self.setup.servos or self._folder / SERVOS
        if self._servos.exists() and not self._servos.is_symlink():
            raise BackendError(
                "there is a file where the servos' link goes", field="servos.port", given=str(self._servos)
            )
        links = f"udp:{self.setup.pixhawk_port}", str(self._servos), f"udp:{self.setup.mocap_port or _UNUSED_PORT}"
        vehicle = self.setup.vehicle or vehicle_config(model, *links)
        self._with_mocap = self.setup.mocap_port > 0
        self.autopilot = self._emulated_autopilot(vehicle.pixhawk, clock) if self.pilot is None else None
        """None where its own code flies."""
        self.gripper = vehicle.gripper
        arm = RigArm(self.plant, self.gripper)
        self.servos = ServoEmulator(_servo_setups(vehicle.servos), arm, link=self._servos, clock=clock)
        self.mocap = MocapEmulator(
            partial(body_seen, self.plant), _tracker_setup(self.plant, vehicle),
            (LOOPBACK, self.setup.mocap_port or _UNUSED_PORT), clock,
        )  # fmt: skip
        self._running: ExitStack | None = None

    def _emulated_autopilot(self, link: PixhawkConfig, clock: Clock) -> EmulatedAutopilot:
        setup, model = self.setup, self.model
        flavour = cast("Flavour", setup.autopilot)
        made = EmulatedAutopilot(
            flavour,
            RigVehicle(self.plant),
            remote=(LOOPBACK, setup.pixhawk_port),
            vision=self._with_mocap,
            start_up=2.0,
            heartbeat_rate=setup.heartbeat_rate,
            hover_thrust=model.vehicle.weight / model.vehicle.max_thrust,
            motors=setup.motors,
            seed=setup.seed,
            clock=clock,
            system_id=link.vehicle_system or 1,
            signing_key=None if link.signing_key is None else load_key(link.signing_key),
        )
        for name, value in {**(DIALECTS[flavour].mocap if self._with_mocap else {}), **_SAFE[flavour]}.items():
            made.parameters[name] = value
        if flavour == "px4" and model.actuation.fully:
            add_rotors(made.parameters, rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust))
        return made

    def _temporary_folder(self) -> Path:
        folder = tempfile.mkdtemp(prefix="doorman-rig-")
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        return Path(folder)

    @property
    def arguments(self) -> tuple[str, ...]:
        """Options of `doorman fly` that fly against this rig."""
        links = ["--pixhawk", f"udp:{self.setup.pixhawk_port}", "--servos", str(self._servos)]
        return (*links, "--mocap", f"udp:{self.setup.mocap_port}") if self._with_mocap else tuple(links)

    @property
    def autopilot_command(self) -> str | None:
        """What starts the autopilot's own code in another terminal; None where the autopilot is emulated."""
        return None if self.pilot is None else self.pilot.command(self.setup.pixhawk_port, self._folder)

    def open(self) -> None:
        """Let the plant move and the emulators talk.

        Raises:
            BackendError: if it runs already, or a port is taken.
        """
        if self._running is not None:
            raise BackendError("the rig runs already", allowed="stop() before another open()")
        with ExitStack() as stack:
            stack.enter_context(self.plant)
            stack.enter_context(self.servos)
            if self.autopilot is not None:
                stack.enter_context(self.autopilot)
            if self._with_mocap:
                stack.enter_context(self.mocap)
            self._running = stack.pop_all()

    def stop(self) -> None:
        """End everything; may be called twice."""
        running, self._running = self._running, None
        if running is not None:
            running.close()

    def _own_code(self) -> RotorPilot | None:
        setup = self.setup
        if setup.autopilot in _SAFE:
            return None
        layout = rotor_layout(self.model.vehicle, self.model.scenario.simulation.torque_per_thrust)
        if setup.autopilot == "px4-sitl":
            return Px4Sitl(layout, setup.sitl_port or simulator_port(setup.pixhawk_port), setup.motors)
        return ArduPilotSitl(layout, setup.sitl_port or SERVO_PORT, setup.motors)
