"""An autopilot that is not there: it speaks MAVLink on loopback as PX4 or ArduPilot does, and flies a plant.

Written from the protocols' documents, not from the adapter. It forgives nothing that the real ones do not.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.copying import Uncopied
from doorman.exceptions import BackendError
from doorman.rig.emulators.autopilot.brain import Brain
from doorman.rig.emulators.autopilot.estimator import Estimate, Estimator
from doorman.rig.emulators.autopilot.link import FaultyUdp, LinkFaults
from doorman.rig.emulators.autopilot.motors import FACTORS, MotorKind, Motors
from doorman.rig.emulators.autopilot.onboard import Build, Flavour, Onboard
from doorman.rig.emulators.autopilot.parameters import ARDUPILOT_DEFAULTS, PX4_DEFAULTS, ParameterStore
from doorman.rig.emulators.autopilot.plant import AutopilotPlant, PlantTruth, SimplePlant
from doorman.rig.emulators.autopilot.protocol import Protocol
from doorman.rig.emulators.autopilot.telemetry import EmulatedBattery

_STEP = 0.004
_MOST_STEPS = 25


class EmulatedAutopilot(Uncopied):
    """A multirotor's autopilot on UDP. The constructor binds nothing; `start` does, on loopback only.

    Args:
        flavour: Whose rules it follows.
        plant: What it flies; a simple vehicle by default.
        local: Address to bind; port 0 takes a free one.
        remote: Whom it sends to from the start, as PX4 does; None waits for the first sender.
        vision: Whether its position comes from VISION_POSITION_ESTIMATE, rather than from satellites.
        system_id: Its MAVLink system id.
        start_up: Until ArduPilot's gyros are calibrated [s].
        heartbeat_rate: [1/s].
        vehicle_type: MAV_TYPE; 13 is a hexarotor.
        hover_thrust: Share of the largest thrust at which the vehicle really hovers.
        motors: Whether it linearises its motors, or, with the factory's parameters, does not.
        pace: Of the autopilot's clock and its plant over real time, as of simulators that run faster or slower.
        signing_key: 32 bytes; with it, unsigned messages are ignored.
        seed: Of noise and faults.
    """

    def __init__(
        self,
        flavour: Flavour = "px4",
        plant: AutopilotPlant | None = None,
        *,
        local: tuple[str, int] = ("127.0.0.1", 0),
        remote: tuple[str, int] | None = None,
        vision: bool = False,
        system_id: int = 1,
        start_up: float = 22.0,
        heartbeat_rate: float = 1.0,
        vehicle_type: int = 13,
        hover_thrust: float = 0.4,
        motors: MotorKind = "linear",
        pace: float = 1.0,
        signing_key: bytes | None = None,
        seed: int = 0,
    ) -> None:
        if flavour not in ("px4", "ardupilot"):
            raise BackendError("unknown autopilot", field="flavour", given=flavour, allowed="px4 or ardupilot")
        px4 = flavour == "px4"
        self.plant: AutopilotPlant = SimplePlant() if plant is None else plant
        self.battery = EmulatedBattery()
        self.parameters = ParameterStore(PX4_DEFAULTS if px4 else ARDUPILOT_DEFAULTS, bytewise=px4)
        if motors == "linear":
            self.parameters[FACTORS[flavour]] = 1.0
        hovers_at = Motors(motors, FACTORS[flavour], self.parameters).normalised(hover_thrust)
        self.parameters["MPC_THR_HOVER" if px4 else "MOT_THST_HOVER"] = hovers_at
        self.build = Build(
            flavour, vision, system_id, start_up, heartbeat_rate, vehicle_type, hover_thrust, motors, signing_key, seed
        )
        self._local, self._remote, self._pace = local, remote, pace
        self._silent_until = 0.0
        self._lock = threading.RLock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._udp: FaultyUdp | None = None
        self._onboard = self._boot()

    # ------------------------------------------------------------ life

    def start(self) -> None:
        """Bind and run.

        Raises:
            BackendError: if it runs already, or the address is taken or not on loopback.
        """
        if self._thread is not None:
            raise BackendError("the emulated autopilot runs already", allowed="stop() first")
        self._udp = FaultyUdp(self._local, self._remote, self.build.seed)
        self._stop.clear()
        self._onboard, self._silent_until = self._boot(), 0.0
        self._thread = threading.Thread(target=self._run, name=f"emulated {self.build.flavour}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread and close the socket; may be called twice."""
        self._stop.set()
        thread, self._thread = self._thread, None
        if thread is not None:
            thread.join(2.0)
        if self._udp is not None:
            self._udp.close()
            self._udp = None

    def __enter__(self) -> EmulatedAutopilot:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def address(self) -> tuple[str, int]:
        """Where it is bound."""
        return self._line.address

    # ------------------------------------------------------------ what a test or a rig may do

    @property
    def outgoing(self) -> LinkFaults:
        """Faults of what it sends."""
        return self._line.outgoing

    @property
    def incoming(self) -> LinkFaults:
        """Faults of what it receives."""
        return self._line.incoming

    @property
    def truth(self) -> PlantTruth:
        """The vehicle as it really is."""
        with self._lock:
            return self.plant.truth()

    @property
    def estimate(self) -> Estimate:
        """What the autopilot believes."""
        return self._onboard.estimate

    @property
    def clock(self) -> float:
        """The autopilot's clock [s]."""
        return self._onboard.clock

    @property
    def brain(self) -> Brain:
        """Modes and rules."""
        return self._onboard.brain

    @property
    def estimator(self) -> Estimator:
        """Takes poses."""
        return self._onboard.estimator

    @property
    def protocol(self) -> Protocol:
        """What was received."""
        return self._onboard.protocol

    def stop_heartbeats(self, stopped: bool = True) -> None:
        """Leave out the heartbeat while all else goes on."""
        self._onboard.heartbeats_stopped = stopped

    def pilot_mode(self, name: str) -> None:
        """The pilot turns the mode switch of the radio: `position`, `land`, `return` and so on."""
        with self._lock:
            self.brain.pilot_mode(name)

    def pilot_sticks(self, velocity: Sequence[float]) -> None:
        """The pilot moves the sticks, which `position` mode obeys, or lets go of them: velocity, world frame [m/s]."""
        with self._lock:
            self.brain.sticks = np.array(velocity, float)

    def kill_switch(self, stop: bool = True) -> None:
        """The pilot stops the motors by the radio's switch, or lets them run again: disarmed it is only after 5 s."""
        with self._lock:
            self.brain.kill(stop)

    def pilot_disarms(self) -> None:
        """The pilot disarms by the radio, wherever the vehicle is."""
        with self._lock:
            self.brain.request_arming(arm=False, forced=True)

    def refuse_arming(self, text: str = "") -> None:
        """Refuse to arm until `allow_arming`, silently or with words."""
        with self._lock:
            self.brain.refusal.active, self.brain.refusal.text = True, text

    def allow_arming(self) -> None:
        """Arm again if the rules are met."""
        with self._lock:
            self.brain.refusal.active = False

    def fail_estimator(self, failed: bool = True) -> None:
        """Lose the position estimate until told otherwise."""
        with self._lock:
            self.estimator.failed = failed

    def confuse(self, confused: bool = True) -> None:
        """Tell attitude and position that are not numbers until told otherwise."""
        with self._lock:
            self._onboard.telemetry.confused = confused

    def forget_origin(self) -> None:
        """Lose the place on earth, as ArduPilot's filter does that begins after it was told."""
        with self._lock:
            self.estimator.origin = None

    def lead_astray(self, offset: Sequence[float]) -> None:
        """Let the position estimate be wrong by this much more, shape (3,), world frame [m], until poses put it right."""
        with self._lock:
            self.estimator.lead_astray(np.asarray(offset, dtype=np.float64))

    def jump_clock(self, seconds: float) -> None:
        """Let the clock jump without a reboot."""
        with self._lock:
            self._onboard.jump_clock(seconds)

    def reboot(self, silence: float = 0.5) -> None:
        """Start anew: disarmed, default mode and rates, clock and sequence numbers from the start.

        Args:
            silence: While nothing is heard or said [s].
        """
        with self._lock:
            self._onboard, self._silent_until = self._boot(), time.monotonic() + silence
            self.plant.stop_motors()

    def say(self, text: str, severity: int = 4) -> None:
        """Send a STATUSTEXT."""
        with self._lock:
            self.brain.say(severity, text)

    def send(self, message: Any) -> None:
        """Send a message in its own name."""
        with self._lock:
            self._onboard.send(message)

    def send_raw(self, data: bytes) -> None:
        """Send bytes as they are."""
        with self._lock:
            self._line.send(data)

    def send_as(self, message: Any, system: int, component: int) -> None:
        """Send a message in another station's name."""
        with self._lock:
            other = mavlink.MAVLink(None, system, component)
            self._line.send(message.pack(other))

    # ------------------------------------------------------------ inside

    @property
    def _line(self) -> FaultyUdp:
        if self._udp is None:
            raise BackendError("the emulated autopilot does not run", allowed="start() first")
        return self._udp

    def _boot(self) -> Onboard:
        return Onboard(self.build, self.plant, self.parameters, self.battery, self._pace, self._transmit)

    def _transmit(self, data: bytes) -> None:
        if self._udp is not None:
            self._udp.send(data)

    def _run(self) -> None:
        stepped = time.monotonic()
        while not self._stop.is_set():
            self._line.wait(max(0.0, stepped + _STEP - time.monotonic()))
            with self._lock:
                silent = time.monotonic() < self._silent_until
                for datagram in self._line.receive():
                    if not silent:
                        self._onboard.receive(datagram)
                if self._onboard.protocol.commands.reboots:
                    self.reboot()
                    continue
                steps = 0
                while stepped + _STEP <= time.monotonic():
                    stepped, steps = stepped + _STEP, steps + 1
                    self._onboard.step(_STEP * self._pace)
                    if steps >= _MOST_STEPS:
                        stepped = time.monotonic()
                if steps and not silent:
                    self._onboard.speak()
                self._line.flush()
