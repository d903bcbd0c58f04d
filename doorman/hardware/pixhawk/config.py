"""Settings of the adapter, checked when made; nothing is opened."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from doorman.checks import Positive, Range, check_fields
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.thrust.curve import ThrustCurve
from doorman.hardware.pixhawk.thrust.tilted_rotors import TiltedRotors
from doorman.hardware.pixhawk.wire.connection import parse_connection
from doorman.hardware.pixhawk.wire.frames import LocalFrame

HEARTBEAT = 1.0
"""Between two heartbeats of an autopilot: what is asked or told again and again is so at this pace [s]."""
PROMPT = 0.3
"""An autopilot that has begun to answer goes on within this; what it owes is asked for again then [s]."""
_Identifier = Annotated[int, Range(1, 255)]


@dataclass(frozen=True)
class Timeouts:
    """After which time something counts as lost, refused or failed [s]."""

    open: Positive = 10.0
    """Longest wait for the first heartbeat, attitude and clock, when the link is opened."""
    link: Positive = 0.5
    """Without any valid message."""
    heartbeat: Positive = 3.0
    """Without a heartbeat: autopilots send one a second."""
    state: Positive = 0.2
    """Age of attitude or position from which a state is stale."""
    clock: Positive = 3.0
    """Without an answer to TIMESYNC that could be used."""
    setpoint: Positive = 0.2
    """Without a setpoint from the controller."""
    mocap: Positive = 0.5
    """Without a fresh pose."""
    battery: Positive = 10.0
    """Without a charge, from an autopilot that has sent one."""
    answer: Positive = 0.7
    """Longest wait for the acknowledgement of a command, before it is sent again."""
    stream_before_mode: Positive = 1.0
    """Setpoints stream so long before the mode is asked for."""
    mode: Positive = 10.0
    """From the request of a mode to the heartbeat that shows it."""
    arming: Positive = 60.0
    """Longest time for arming, tried again and again; ArduPilot's gyros alone take about 22 s."""
    take_off: Positive = 30.0
    """Longest time for the climb to the wanted height."""
    landing: Positive = 60.0
    """From the request to land until the vehicle is disarmed."""
    stop: Positive = 1.5
    """Longest wait for the autopilot to confirm that it lands, when the link is closed in the air."""

    def __post_init__(self) -> None:
        check_fields(self, "pixhawk.timeouts.")


@dataclass(frozen=True)
class Rates:
    """Messages per second [1/s]."""

    attitude: Positive = 200.0
    """Attitude and body rates asked of the autopilot."""
    position: Positive = 100.0
    """Position and velocity asked of the autopilot."""
    setpoint: Positive = 100.0
    """Setpoints to the autopilot; 10 at least."""
    heartbeat: Positive = 2.0
    """Our heartbeats."""
    timesync: Positive = 10.0
    """Requests by which the autopilot's clock is known."""
    mocap: Positive = 50.0
    """Poses to the autopilot at most; those that come faster are thinned."""

    def __post_init__(self) -> None:
        check_fields(self, "pixhawk.rates.")


@dataclass(frozen=True)
class PixhawkConfig:
    """Everything that the adapter needs to know."""

    connection: str
    """`udp:14540`, `udpout:HOST:PORT`, `tcp:HOST:PORT`, `serial:/dev/ttyACM0:921600`; see `parse_connection`."""
    setpoints: Literal["attitude", "position"] = "attitude"
    """What the controller sends; decides what is required before `engage`."""
    mocap: bool = False
    """Whether poses are sent to the autopilot and their loss is watched."""
    hover_force: Positive | None = None
    """Weight of the vehicle, from which a missing thrust curve is made by the autopilot's own hover thrust [N]."""
    thrust_curve: ThrustCurve | None = None
    """Newtons to normalised thrust; needed for attitude setpoints."""
    rotors: TiltedRotors | None = None
    """Rotors of a fully actuated vehicle; attitude setpoints carry a force to the side then."""
    local_frame: LocalFrame = LocalFrame()
    """Place and heading of the autopilot's local frame in the world."""
    vehicle_system: _Identifier | None = None
    """System id of the vehicle; by default that of the first multirotor heard."""
    system_id: _Identifier = 255
    """Our system id; 255 is what autopilots expect of the station whose loss they act on."""
    component_id: _Identifier = 190
    """Our component id."""
    ground_station: bool = True
    """Whether our heartbeat is a ground station's, whose loss trips the autopilot's own failsafe."""
    origin: tuple[float, float, float] | None = (47.397742, 8.545594, 488.0)
    """Latitude [°], longitude [°], altitude [m] given to ArduPilot without GPS. Any place will do, except sea level: at an
    altitude of zero ArduPilot resets its height every second."""
    signing_key: Path | None = None
    """File with the MAVLink signing key; unsigned messages are then ignored."""
    listen_only: bool = False
    """Whether nothing at all is sent, not even heartbeats: then there is no clock, and no state is ever fresh."""
    write_parameters: bool = False
    """Whether `fix_parameters` may write."""
    on_mocap_loss: Literal["land", "report"] = "land"
    """What follows when poses stay away for `timeouts.mocap`."""
    on_stop: Literal["land", "leave"] = "land"
    """What a vehicle that we still fly does when the link is closed."""
    min_battery: float = 0.2
    """Share of the charge below which it counts as low."""
    min_voltage: Positive | None = None
    """Voltage below which it counts as low [V]."""
    climb_rate: Positive = 0.5
    """Speed of the climb at take-off [m/s]."""
    timeouts: Timeouts = Timeouts()
    rates: Rates = Rates()

    def __post_init__(self) -> None:
        parse_connection(self.connection)
        check_fields(self, "pixhawk.")
        latitude, longitude, altitude = self.origin or (0.0, 0.0, 1.0)
        if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0 and 1.0 <= abs(altitude) <= 9000.0):
            allowed = "latitude up to 90°, longitude up to 180°, altitude of 1 to 9000 m, or as deep"
            raise BackendError("not a place on earth", field="pixhawk.origin", given=self.origin, allowed=allowed)
        if self.rates.setpoint < 10.0:
            raise BackendError(
                "too slow: the autopilot would leave its mode", field="pixhawk.rates.setpoint", allowed=">= 10 1/s"
            )
