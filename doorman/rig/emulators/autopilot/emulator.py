"""An autopilot that is not there: it speaks MAVLink on loopback as PX4 or ArduPilot does, and flies a plant.

Written from the protocols' documents, not from the adapter. What only the autopilots' own code has it lacks.
"""

from __future__ import annotations

from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.background import InThread
from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.rig.emulators.autopilot.brain import Brain
from doorman.rig.emulators.autopilot.control import (
    Demand,
    FlightController,
    Task,
    normalised_thrust,
    side_force,
    thrust_share,
)
from doorman.rig.emulators.autopilot.dialects import Build, Flavour, ParameterStore
from doorman.rig.emulators.autopilot.estimator import AutopilotPlant, Estimator, PlantTruth, SimplePlant
from doorman.rig.emulators.autopilot.line import BootClock, FaultyUdp, LinkFaults
from doorman.rig.emulators.autopilot.receiver import Receiver
from doorman.rig.emulators.autopilot.telemetry import EmulatedBattery, Telemetry

_MOST_STEPS = 25


class EmulatedAutopilot(InThread):
    """A multirotor's autopilot on UDP. The constructor binds nothing; `open` does, on loopback only."""

    step = 0.004  # of plant and rules [s]

    # Its parts may be looked into, and their plain fields set, at any time: a reboot makes `brain`, `estimator`, `telemetry`,
    # `receiver` and `clock` anew.

    def __init__(
        self,
        flavour: Flavour = "px4",
        plant: AutopilotPlant | None = None,
        *,
        local: tuple[str, int] = ("127.0.0.1", 0),
        remote: tuple[str, int] | None = None,
        clock: Clock = REAL_TIME,
        **build: Any,
    ) -> None:
        super().__init__(f"emulated {flavour}", clock)
        self.build = Build(flavour, **build)
        dialect, share = self.build.dialect, self.build.hover_thrust
        self.plant: AutopilotPlant = SimplePlant() if plant is None else plant
        self.battery = EmulatedBattery()
        self.outgoing, self.incoming = LinkFaults(), LinkFaults()
        self.parameters = ParameterStore(dialect.parameters, dialect.bytewise)
        if self.build.motors == "linear":
            self.parameters[dialect.linearisation] = 1.0
        self.parameters[dialect.hover_thrust] = normalised_thrust(share, self.parameters[dialect.linearisation])
        self.lock = clock.lock()  # held while it thinks: whoever calls into its parts from another thread takes it
        self._local, self._remote = local, remote
        self._udp: FaultyUdp | None = None
        self._boot()

    @property
    def address(self) -> tuple[str, int]:
        return self._line.address

    @property
    def truth(self) -> PlantTruth:
        with self.lock:
            return self.plant.truth()

    # ------------------------------------------------------------ what a test or a rig may do

    def pilot_mode(self, name: str) -> None:
        with self.lock:
            self.brain.pilot_mode(name)

    def kill_switch(self, stop: bool = True) -> None:
        """Stop the motors by the radio's switch, or let them run again; the vehicle is disarmed only after 5 s."""
        with self.lock:
            self.brain.kill(stop)

    def pilot_disarms(self) -> None:
        with self.lock:
            self.brain.disarm()

    def reboot(self, silence: float = 0.5) -> None:
        """Start anew: disarmed, default mode and rates, clock and sequence numbers from the start."""
        with self.lock:
            self._boot()
            self._silent_until = self._clock.now() + silence
            self.plant.stop_motors()

    def send(self, message: Any, station: tuple[int, int] | None = None) -> None:
        with self.lock:
            if station is None:
                self.telemetry.send(message)
            else:
                self._line.send(message.pack(mavlink.MAVLink(None, *station)))

    # ------------------------------------------------------------ inside

    @property
    def _line(self) -> FaultyUdp:
        if self._udp is None:
            raise BackendError("the emulated autopilot does not run", allowed="open() first")
        return self._udp

    def _begin(self) -> None:
        self._udp = FaultyUdp(self._local, self._remote, (self.outgoing, self.incoming), self.build.seed, self._clock)
        self._boot()

    def _end(self) -> None:
        self._line.close()
        self._udp = None

    def _boot(self) -> None:
        build, self.clock, self._silent_until = self.build, BootClock(self.build.pace, self._clock), 0.0
        dialect, now = build.dialect, self.clock.uptime
        truth, timeout, needs_origin = self.plant.truth(), dialect.position_timeout, not dialect.heeds_stream
        self.estimator = Estimator(now, truth, timeout, needs_origin, vision=build.vision, seed=build.seed)
        start_up = 0.0 if dialect.heeds_stream else build.start_up
        self.brain = Brain(dialect, self.parameters, now, self.estimator.estimate, start_up)
        self.telemetry = Telemetry(self.brain, self.estimator, self.battery, self.clock, build, self._transmit)
        self.receiver = Receiver(self.brain, self.estimator, self.telemetry, self.clock, build.system_id)
        self._controller = FlightController(self.plant.weight)

    def _transmit(self, data: bytes) -> None:
        if self._udp is not None:
            self._udp.send(data)

    def _run(self) -> None:
        stepped = self._clock.now()
        while not self._stopping.is_set():
            self._line.wait(max(0.0, stepped + self.step - self._clock.now()))
            with self.lock:
                silent = self._clock.now() < self._silent_until
                for datagram in self._line.receive():
                    if not silent:
                        self._receive(datagram)
                steps = 0
                while stepped + self.step <= self._clock.now():
                    stepped, steps = stepped + self.step, steps + 1
                    self._step(self.step * self.build.pace)
                    if steps >= _MOST_STEPS:
                        stepped = self._clock.now()
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
                self.receiver.take(message)

    def _step(self, dt: float) -> None:
        now, truth = self.clock.uptime, self.plant.truth()
        estimate = self.estimator.update(now, truth, dt)
        demand = self.brain.update(now, estimate, truth.on_ground, now - self.receiver.station_heard)
        if demand.task is Task.IDLE:
            self.plant.stop_motors()
            self.telemetry.normalised, self.telemetry.steered = 0.0, estimate.quaternion
        else:
            self._drive(demand)
        self.plant.advance(dt)

    def _drive(self, demand: Demand) -> None:
        """Ask the mixer for thrust: the force of `THR_MDL_FAC` and `MOT_THST_EXPO` as the autopilot believes it."""
        build, weight = self.build, self.plant.weight
        k = self.parameters[build.dialect.linearisation]
        full, most = weight / normalised_thrust(build.hover_thrust, k), weight / build.hover_thrust
        force, attitude = self._controller.actuate(demand, self.estimator.estimate, full)
        normalised = min(max(force / full, 0.0), 1.0)
        self.telemetry.normalised, self.telemetry.steered = normalised, attitude
        side = side_force(self.parameters, demand.side, most)
        self.plant.command(thrust_share(normalised, k) * most, attitude, side)
