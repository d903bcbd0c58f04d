"""The simulator as a backend: what the mission loop flies instead of a vehicle."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from functools import reduce

from doorman.checks import vector
from doorman.exceptions import BackendError, DimensionError
from doorman.model import Model
from doorman.recording import Recorder
from doorman.signals import Backend, Command, Measurement
from doorman.simulation.delay_line import DelayLine
from doorman.simulation.door_sensor.readings import DoorReadings, door_readings
from doorman.simulation.gusts import Gust, together
from doorman.simulation.hand import Hand
from doorman.simulation.plant.onboard.attitude_loop import AttitudeGains
from doorman.simulation.sensors import Sensors
from doorman.simulation.simulator import DisturbanceSource, Simulator
from doorman.simulation.truth import Truth


class SimulatedBackend(Backend):
    """MuJoCo plant behind the interface of the hardware.

    One `read` is one period of the controller. The physics takes a whole number of steps in it, so its step is the nearest
    to 1/`simulation.physics_rate` that divides the period. The last command holds meanwhile; before the first it is hover.

    Args:
        model: The model.
        seed: Of noise, gaps and gusts; the same seed gives the same flight to the bit.
        recorder: Gets a message `truth` at every tick.
        realtime: Whether `read` waits so that simulated time does not run ahead of the wall clock.
        disturbance: What else acts on the plant, beside the scenario's gusts and its hand.
        gains: Of the onboard attitude loop; those of `simulation.attitude_*` if not given.
        after: Backend of the step before, stopped: this one begins where its plant has ended.
    """

    def __init__(
        self,
        model: Model,
        seed: int = 0,
        recorder: Recorder | None = None,
        realtime: bool = False,
        *,
        disturbance: DisturbanceSource | None = None,
        gains: AttitudeGains | None = None,
        after: SimulatedBackend | None = None,
    ) -> None:
        self.model = model
        self._after = after
        self.seed = seed
        simulation = model.scenario.simulation
        self.period = 1.0 / simulation.controller_rate
        self.steps_per_period = max(1, round(simulation.physics_rate / simulation.controller_rate))
        self._recorder = recorder
        self._realtime = realtime
        self._disturbance = disturbance
        self._gains = gains
        self._simulator: Simulator | None = None
        self._last: Simulator | None = None
        self._sensors: Sensors | None = None
        self._link: DelayLine[Command] | None = None
        self._door: DoorReadings | None = None
        self._truth: Truth | None = None
        self._ticks = 0
        self._wall_start = 0.0

    @property
    def truth(self) -> Truth:
        """The plant as it was at the last `read`, or at the start before the first; kept after `stop`.

        Raises:
            BackendError: if the backend was never opened.
        """
        if self._truth is None:
            raise BackendError("no truth yet: the simulation was not opened", allowed="open() before truth")
        return self._truth

    @property
    def feedback_lag(self) -> float:
        """The simulated loop answers moments as it follows set points; see `Backend`."""
        return 0.0

    def open(self) -> None:
        """Build the plant and put it at the scenario's start; a stopped backend starts afresh.

        Raises:
            BackendError: if it is open already, MuJoCo is missing or it cannot build the plant.
        """
        if self._simulator is not None:
            raise BackendError("the simulation is open already", allowed="stop() before another open()")
        self._simulator = Simulator(
            self.model, self.period / self.steps_per_period, self._disturbances(), self._gains,
            None if self._after is None else self._after._last,
        )  # fmt: skip
        simulation = self.model.scenario.simulation
        self._sensors = Sensors(simulation.noise, self.seed, simulation.sensors, simulation.servo_backlash)
        self._door = door_readings(self._simulator, self.seed) if simulation.door_sensor.works else None
        self._link = DelayLine(0.0, simulation.command_jitter, simulation.command_rate, self.seed)
        self._truth = self._simulator.truth()
        self._ticks = 0

    def read(self, periods: int = 1) -> Measurement:
        """Advance by one period of the controller and measure; the first call measures the start, at time 0.

        Args:
            periods: Advance by so many periods, and measure at their end alone: sensors sample no faster then.

        Returns:
            The measurement. Its truth has the contacts of all these periods.

        Raises:
            BackendError: if the simulation is not open, or the physics became unstable.
        """
        simulator = self._opened()
        if self._ticks > 0:
            self._advance(simulator, periods * self.steps_per_period)
        elif self._realtime:
            self._wall_start = time.monotonic()
        self._truth = simulator.truth()
        self._ticks += 1
        if self._recorder is not None:
            self._recorder.write("truth", self._truth.time, self._truth.fields())
        if self._realtime:
            ahead = self._truth.time - (time.monotonic() - self._wall_start)
            if ahead > 0.0:
                time.sleep(ahead)
        assert self._sensors is not None
        measured = self._sensors.measure(self._truth)
        if self._door is None:
            return measured
        leaf, frame = self._door(self._truth)
        return replace(measured, leaf=leaf, frame=frame)

    def command(self, command: Command) -> None:
        """Hold a command from now on.

        Args:
            command: Thrust, attitude and joint rates; limits are those of rotors and servos.

        Raises:
            BackendError: if the simulation is not open, or the command is not finite or of wrong shape.
        """
        simulator = self._opened()
        try:
            thrust = float(command.thrust)
            attitude = vector(command.attitude, 3, "command.attitude")
            arm_rates = vector(command.arm_rates, self.model.n_arm, "command.arm_rates")
            side_force = vector(command.side_force, 2, "command.side_force")
        except (DimensionError, TypeError, ValueError) as error:
            raise BackendError(f"not a command: {error}", field="command") from error
        if not math.isfinite(thrust):
            raise BackendError("not finite", field="command.thrust", given=thrust, allowed="finite numbers")
        assert self._link is not None
        ahead, left = side_force.tolist()
        checked = Command(thrust, attitude, arm_rates, bool(command.grip), (ahead, left))
        self._link.send(simulator.time, checked)
        self._follow(simulator)

    def stop(self) -> None:
        """Let go of the plant; the last `truth` stays. May be called twice."""
        self._last, self._simulator = self._simulator or self._last, None
        self._sensors = self._door = None

    def _follow(self, simulator: Simulator) -> None:
        """Take what the link has brought."""
        assert self._link is not None
        if (command := self._link.arrived(simulator.time)) is not None:
            simulator.set_command(command.thrust, command.attitude, command.arm_rates, command.side_force)
            simulator.set_grip(command.grip)

    def _advance(self, simulator: Simulator, steps: int) -> None:
        """Physics steps; a command that comes between two ticks is taken then."""
        assert self._link is not None
        if self._link.is_plain:
            simulator.advance(steps)
            return
        for _ in range(steps):
            self._follow(simulator)
            simulator.advance(1)

    def _disturbances(self) -> DisturbanceSource | None:
        """The caller's disturbance, the scenario's gusts and its hand together."""
        simulation, given = self.model.scenario.simulation, self._disturbance
        sources: list[DisturbanceSource] = []
        if simulation.gust.blows:
            gust = Gust(simulation.gust, self.model.true_door, self.seed)
            sources.append(lambda time: gust.at(time, self._opened().plant.door_angle))
        if simulation.hand.door_angle is not None:
            hand = Hand(simulation.hand)
            sources.append(lambda time: hand.at(time, (plant := self._opened().plant).door_angle, plant.door_rate))
        if given is not None:
            sources.append(given)
        if len(sources) < 2:
            return sources[0] if sources else None
        return lambda time: reduce(together, (source(time) for source in sources))

    def _opened(self) -> Simulator:
        if self._simulator is None:
            raise BackendError("the simulation is not open", allowed="open() before read() and command()")
        return self._simulator
