"""An autopilot that is not there: it speaks MAVLink on loopback as PX4 or ArduPilot does, and flies a plant.

Written from the protocols' documents, not from the adapter. What only the autopilots' own code has it lacks.
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
from doorman.rig.emulators.autopilot.allocation import side_force
from doorman.rig.emulators.autopilot.brain import Brain
from doorman.rig.emulators.autopilot.build import Build
from doorman.rig.emulators.autopilot.clock import Clock
from doorman.rig.emulators.autopilot.control import Demand, FlightController, Task
from doorman.rig.emulators.autopilot.dialects import Flavour
from doorman.rig.emulators.autopilot.estimator import Estimate, Estimator
from doorman.rig.emulators.autopilot.link import FaultyUdp, LinkFaults
from doorman.rig.emulators.autopilot.motors import normalised_thrust, thrust_share
from doorman.rig.emulators.autopilot.parameters import ParameterStore
from doorman.rig.emulators.autopilot.plant import AutopilotPlant, PlantTruth, SimplePlant
from doorman.rig.emulators.autopilot.protocol import Protocol
from doorman.rig.emulators.autopilot.telemetry import EmulatedBattery, Telemetry

_STEP = 0.004
_MOST_STEPS = 25


class EmulatedAutopilot(Uncopied):
    """A multirotor's autopilot on UDP. The constructor binds nothing; `start` does, on loopback only.

    Args:
        flavour: Whose rules it follows.
        plant: What it flies; a simple vehicle by default.
        local: Address to bind; port 0 takes a free one.
        remote: Whom it sends to from the start, as PX4 does; None waits for the first sender.
        build: Further fields of `Build`.
    """

    def __init__(
        self,
        flavour: Flavour = "px4",
        plant: AutopilotPlant | None = None,
        *,
        local: tuple[str, int] = ("127.0.0.1", 0),
        remote: tuple[str, int] | None = None,
        **build: Any,
    ) -> None:
        self.build = Build(flavour, **build)
        dialect, share = self.build.dialect, self.build.hover_thrust
        self.plant: AutopilotPlant = SimplePlant() if plant is None else plant
        self.battery = EmulatedBattery()
        self.parameters = ParameterStore(dialect.parameters, dialect.bytewise)
        if self.build.linear:
            self.parameters[dialect.linearisation] = 1.0
        self.parameters[dialect.hover_thrust] = normalised_thrust(share, self.parameters[dialect.linearisation])
        self._local, self._remote, self._silent_until = local, remote, 0.0
        self._lock = threading.RLock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._udp: FaultyUdp | None = None
        self._boot()

    def start(self) -> None:
        """Bind and run.

        Raises:
            BackendError: if it runs already, or the address is taken or not on loopback.
        """
        if self._thread is not None:
            raise BackendError("the emulated autopilot runs already", allowed="stop() first")
        self._udp = FaultyUdp(self._local, self._remote, self.build.seed)
        self._stop.clear()
        self._boot()
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
        """Address to which it is bound."""
        return self._line.address

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
        return self.estimator.estimate

    @property
    def clock(self) -> float:
        """The autopilot's clock [s]."""
        return self._clock.now

    # ------------------------------------------------------------ what a test or a rig may do

    def pilot_mode(self, name: str) -> None:
        """Turn the mode switch of the pilot's radio.

        Args:
            name: Of the mode: `position`, `land`, `return` and so on.
        """
        with self._lock:
            self.brain.pilot_mode(name)

    def pilot_sticks(self, velocity: Sequence[float]) -> None:
        """Move the pilot's sticks, which `position` mode obeys, or let go of them.

        Args:
            velocity: That they ask for, shape (3,), world frame [m/s]; zero without a hand on them.
        """
        self.brain.sticks = np.array(velocity, float)

    def kill_switch(self, stop: bool = True) -> None:
        """Stop the motors by the radio's switch, or let them run again; the vehicle is disarmed only after 5 s.

        Args:
            stop: Whether they stop.
        """
        with self._lock:
            self.brain.kill(stop)

    def pilot_disarms(self) -> None:
        """The pilot disarms by the radio, wherever the vehicle is."""
        with self._lock:
            self.brain.request_arming(arm=False, forced=True)

    def refuse_arming(self, text: str = "") -> None:
        """Refuse to arm until `allow_arming`.

        Args:
            text: Words of the refusal; empty for a silent one.
        """
        self.brain.refusal = text

    def allow_arming(self) -> None:
        """Arm again if the rules are met."""
        self.brain.refusal = None

    def fail_estimator(self, failed: bool = True) -> None:
        """Lose the position estimate, or find it again.

        Args:
            failed: Whether it is lost.
        """
        self.estimator.failed = failed

    def forget_origin(self) -> None:
        """Lose the place on earth, as ArduPilot's filter does that begins after it got one."""
        self.estimator.origin = None

    def lead_astray(self, offset: Sequence[float]) -> None:
        """Let the position estimate be wrong by more, until poses put it right.

        Args:
            offset: By which, shape (3,), world frame [m].
        """
        with self._lock:
            self.estimator.lead_astray(np.asarray(offset, dtype=np.float64))

    def confuse(self, confused: bool = True) -> None:
        """Send attitude and position that are NaN, or numbers again.

        Args:
            confused: Whether they are NaN.
        """
        self.telemetry.confused = confused

    def stop_heartbeats(self, stopped: bool = True) -> None:
        """Leave out the heartbeat while all else goes on, or send it again.

        Args:
            stopped: Whether it is left out.
        """
        self.telemetry.heartbeats_stopped = stopped

    def jump_clock(self, seconds: float) -> None:
        """Let the clock jump without a reboot.

        Args:
            seconds: By which it jumps [s].
        """
        self._clock.jumped += seconds

    def reboot(self, silence: float = 0.5) -> None:
        """Start anew: disarmed, default mode and rates, clock and sequence numbers from the start.

        Args:
            silence: While nothing is heard or said [s].
        """
        with self._lock:
            self._boot()
            self._silent_until = time.monotonic() + silence
            self.plant.stop_motors()

    def send(self, message: Any) -> None:
        """Send a message in its own name.

        Args:
            message: Of pymavlink.
        """
        with self._lock:
            self.telemetry.send(message)

    def send_as(self, message: Any, system: int, component: int) -> None:
        """Send a message in another station's name.

        Args:
            message: Of pymavlink.
            system: Of the other station.
            component: Of the other station.
        """
        with self._lock:
            self._line.send(message.pack(mavlink.MAVLink(None, system, component)))

    # ------------------------------------------------------------ inside

    @property
    def _line(self) -> FaultyUdp:
        if self._udp is None:
            raise BackendError("the emulated autopilot does not run", allowed="start() first")
        return self._udp

    def _boot(self) -> None:
        build, dialect, clock = self.build, self.build.dialect, Clock(self.build.pace)
        self._clock, self._silent_until = clock, 0.0
        start_up = 0.0 if dialect.heeds_stream else build.start_up
        self.estimator = Estimator(dialect, clock.uptime, self.plant.truth(), vision=build.vision, seed=build.seed)
        self.brain = Brain(dialect, self.parameters, clock.uptime, self.estimator.estimate, start_up)
        self.telemetry = Telemetry(self.brain, self.estimator, self.battery, clock, build, self._transmit)
        self.protocol = Protocol(self.brain, self.estimator, self.telemetry, clock, build.system_id)
        self._controller = FlightController(self.plant.weight)

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
                        self._receive(datagram)
                steps = 0
                while stepped + _STEP <= time.monotonic():
                    stepped, steps = stepped + _STEP, steps + 1
                    self._step(_STEP * self.build.pace)
                    if steps >= _MOST_STEPS:
                        stepped = time.monotonic()
                if steps and not silent:
                    self.telemetry.speak()
                self._line.flush()

    def _receive(self, datagram: bytes) -> None:
        try:
            messages = self.telemetry.mav.parse_buffer(datagram) or []
        except mavlink.MAVError:
            return
        for message in messages:
            if message.get_type() != "BAD_DATA":
                self.protocol.take(message)

    def _step(self, dt: float) -> None:
        """Estimate, decide, control, and let the plant move [s]."""
        now, truth = self._clock.uptime, self.plant.truth()
        estimate = self.estimator.update(now, truth, dt)
        demand = self.brain.update(now, estimate, truth.on_ground, now - self.protocol.station_heard)
        if demand.task is Task.IDLE:
            self.plant.stop_motors()
            self.telemetry.normalised, self.telemetry.steered = 0.0, estimate.quaternion
        else:
            self._drive(demand)
        self.plant.advance(dt)

    def _drive(self, demand: Demand) -> None:
        """Ask the mixer for thrust: the force of `THR_MDL_FAC` and `MOT_THST_EXPO` as the autopilot believes it."""
        build, k = self.build, self.parameters[self.build.dialect.linearisation] if not self.build.linear else 1.0
        full = self.plant.weight / normalised_thrust(build.hover_thrust, k)
        force, self.telemetry.steered = self._controller.actuate(demand, self.estimate, full)
        self.telemetry.normalised = normalised = min(max(force / full, 0.0), 1.0)
        most = self.plant.weight / build.hover_thrust
        side = side_force(self.parameters, demand.side, most)
        self.plant.command(thrust_share(normalised, k) * most, self.telemetry.steered, side)
