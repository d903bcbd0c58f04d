"""What an emulated autopilot is built as."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.exceptions import BackendError
from doorman.rig.emulators.autopilot.rules.dialects import DIALECTS, Dialect, Flavour
from doorman.rig.emulators.autopilot.vehicle.mixer import MotorKind


@dataclass(frozen=True)
class Build:
    """What no reboot changes."""

    flavour: Flavour = "px4"  # whose rules it follows
    vision: bool = False  # whether its position comes from VISION_POSITION_ESTIMATE, rather than from satellites
    system_id: int = 1  # its MAVLink system id
    start_up: float = 22.0  # until ArduPilot's gyros are calibrated [s]
    heartbeat_rate: float = 1.0  # [1/s]
    vehicle_type: int = 13  # MAV_TYPE; 13 is a hexarotor
    hover_thrust: float = 0.4  # share of the largest thrust at which the vehicle really hovers
    motors: MotorKind = "linear"
    """Whether its parameter linearises the motors, or is the factory's; thrust is the square of their signal with both."""
    pace: float = 1.0  # of its clock and its plant over real time, as of simulators that run faster or slower
    signing_key: bytes | None = None  # 32 bytes; with it, unsigned messages are ignored
    seed: int = 0  # of noise and faults

    def __post_init__(self) -> None:
        if self.flavour not in DIALECTS:
            raise BackendError("unknown autopilot", field="flavour", given=self.flavour, allowed="px4 or ardupilot")

    @property
    def dialect(self) -> Dialect:
        """Rules of the autopilot, as data."""
        return DIALECTS[self.flavour]
