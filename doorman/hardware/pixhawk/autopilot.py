"""The Pixhawk as the mission sees it: state in, setpoints and poses out, and the steps of a flight."""

from __future__ import annotations

from dataclasses import replace

from numpy.typing import ArrayLike

from doorman.clocks import LOOK
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.config import HEARTBEAT, PROMPT
from doorman.hardware.pixhawk.events import RARELY, Event
from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.link.status import LinkStatus, link_status
from doorman.hardware.pixhawk.parameters import protocol as parameters
from doorman.hardware.pixhawk.parameters.protocol import Finding, side_force_missing
from doorman.hardware.pixhawk.parameters.rules import Rule, rules_for
from doorman.hardware.pixhawk.sample import SampleStatus, VehicleSample
from doorman.hardware.pixhawk.sequences import FlightSteps
from doorman.hardware.pixhawk.setpoints import AttitudeSetpoint, PositionSetpoint, Setpoint
from doorman.hardware.pixhawk.thrust.curve import ThrustCurve, hover_curve
from doorman.hardware.pixhawk.thrust.slope import BOB_TIME, Slope, ThrustModel, bob, measured_slope
from doorman.hardware.pixhawk.wire.messages import mavlink


class Autopilot(FlightSteps):
    """A PX4 or ArduPilot multirotor on a MAVLink connection. The constructor touches no device.

    `state`, `setpoint`, `mocap`, `events` and `status` never wait for the line; the steps of a flight do, with time-outs.

    Args:
        config: Settings.
        clock: Clock of all its waits.
    """

    def open(self) -> None:
        """Connect, and wait for heartbeat, attitude and clock.

        Raises:
            BackendError: if it is open already, the line cannot be opened, or the autopilot is silent.
        """
        if self._link.alive:
            raise BackendError("the link is open already", field="pixhawk.connection", given=self.config.connection)
        self._link = Link(self.config, self._clock)
        self._link.open()
        try:
            self._await_autopilot()
        except BaseException:
            self._link.stop()
            raise

    def stop(self) -> None:
        """Land what still flies by our setpoints (`on_stop`), end the thread and close the line; may be called twice."""
        try:
            if self._link.alive and self._link.identity is not None:
                self._leave()
        finally:
            self._link.stop()

    def state(self) -> VehicleSample:
        """Newest state, with its status as of now: only `FRESH` may be flown on."""
        sample, now = self._link.tracker.sample, self._clock.now()
        age = sample.age(now)
        if age == float("inf"):
            status = SampleStatus.INCOMPLETE
        elif age > self.config.timeouts.state or not self._link.clock.synchronised or not self._link.alive:
            status = SampleStatus.STALE
        else:
            status = SampleStatus.FRESH
        return replace(sample, status=status)

    def setpoint(self, setpoint: Setpoint) -> bool:
        """Fly by a setpoint from now on; the stream takes the newest.

        Args:
            setpoint: Attitude and thrust, or position.

        Returns:
            False if the vehicle is not ours: not engaged, taking off, held by `hold(latch=True)`, landing, or taken over by
            radio or failsafe.

        Raises:
            BackendError: if it is an attitude setpoint and there is no thrust curve.
        """
        if isinstance(setpoint, AttitudeSetpoint) and self._link.stream.curve is None:
            raise BackendError("attitude setpoints need a thrust curve", field="pixhawk.thrust_curve",
                               allowed="a ThrustCurve, or hover_force")  # fmt: skip
        return self._link.stream.offer(setpoint, self._clock.now())

    def mocap(self, time_of_capture: float, position: ArrayLike, quaternion: ArrayLike) -> bool:
        """Hand over a pose for the autopilot's estimator.

        Args:
            time_of_capture: When it was true, by `time.monotonic()` [s].
            position: Shape (3,), world frame [m].
            quaternion: [w, x, y, z], body to world, shape (4,).

        Returns:
            False if it is too old, from the future, or not newer than the last.

        Raises:
            DimensionError: if it is not a pose.
        """
        return self._link.mocap.offer(time_of_capture, position, quaternion, self._clock.now())

    def events(self) -> tuple[Event, ...]:
        """Events since the last call, oldest first."""
        return tuple(self._link.events.take())

    def complaints(self) -> tuple[str, ...]:
        """Texts of severity warning or worse in the last minute, each once: the autopilot repeats those that hold."""
        return tuple(self._link.exchange.texts(self._clock.now() - RARELY, mavlink.MAV_SEVERITY_WARNING))

    def check_again(self) -> tuple[str, ...]:
        """Have the autopilot check now whether it would arm, on the ground; unasked, it says why not twice a minute.

        Returns:
            What it says to that; `complaints` if it says nothing.
        """
        started = self._clock.now()
        self._link.command(mavlink.MAV_CMD_RUN_PREARM_CHECKS, tries=2)
        self._link.until(lambda: bool(self._link.exchange.texts(started)), HEARTBEAT)
        self._clock.sleep(PROMPT)
        return tuple(self._link.exchange.texts(started, mavlink.MAV_SEVERITY_WARNING)) or self.complaints()

    def status(self) -> LinkStatus:
        """Figures of the link as of now."""
        return link_status(self._link, self._clock.now())

    def check_parameters(self) -> tuple[Finding, ...]:
        """Hold the autopilot's parameters against what this set-up needs; reads only.

        Returns:
            What should be changed, and how; empty if all is well.
        """
        return parameters.check(self._link, self._rules())

    def side_force_missing(self) -> str:
        """Why the autopilot makes no force to the side; nothing where it does, or the vehicle's rotors make none."""
        return side_force_missing(self._link)

    def fix_parameters(self) -> tuple[str, ...]:
        """Write what `check_parameters` finds; some of it counts only after a reboot of the autopilot.

        Returns:
            Names of the parameters that were written and read back.

        Raises:
            BackendError: unless `write_parameters` is set, and the autopilot is heard and disarmed.
        """
        return parameters.fix(self._link, self._rules())

    def resume(self) -> None:
        """Let the controller's setpoints in again after a latched hold."""
        self._link.stream.release()

    def request_landing(self) -> bool:
        """Ask for the landing mode without waiting; asked again until the heartbeat shows it.

        Returns:
            False if the vehicle is not ours.
        """
        return self._link.request_landing()

    def _heard(self, duration: float) -> list[VehicleSample]:
        """The samples of a while, as they come."""
        samples: list[VehicleSample] = []

        def note() -> bool:
            samples.append(self._link.tracker.sample)
            return False

        self._link.until(note, duration)
        return samples

    def calibrate_hover(
        self, hover_force: float, duration: float = 3.0, *, compensate_battery: bool = False
    ) -> ThrustCurve:
        """Measure the normalised thrust in hover, and use it from now on; the vehicle must hold.

        Args:
            hover_force: Weight of the vehicle [N].
            duration: [s].
            compensate_battery: For autopilots that do not compensate the battery themselves.

        Returns:
            The curve.

        Raises:
            BackendError: if the vehicle does not hover calmly.
        """
        old = self._link.stream.curve
        curve = hover_curve(self._heard(duration), hover_force, 0.0 if old is None else old.shape, compensate_battery)
        if old is not None:
            curve = replace(
                old, hover_thrust=curve.hover_thrust, hover_force=hover_force, hover_voltage=curve.hover_voltage
            )
        self._link.stream.curve = curve
        return curve

    def measure_slope(self, at: PositionSetpoint) -> Slope | None:
        """Measure how steeply thrust grows with its setpoint, by bobbing up and aside a little; the vehicle must hold.

        Args:
            at: Where it holds.

        Returns:
            The slope, by the thrust curve in use; None if the vehicle is not ours, or too little was heard.
        """
        link, samples, begin = self._link, list[VehicleSample](), self._clock.now()
        curve = link.stream.curve
        while (passed := self._clock.now() - begin) < BOB_TIME:
            if not link.stream.offer(bob(at, passed), self._clock.now()):
                return None
            samples += self._heard(LOOK)
        if not link.authority.hold(at, latch=False) or curve is None:
            return None
        return measured_slope(samples, curve.hover_thrust)

    @property
    def thrust_model(self) -> ThrustModel | None:
        """Parameter by which the autopilot undoes the motors' curve, as `engage` has read it; None where it has none."""
        return self._link.stream.thrust_model

    def shape_thrust(self, shape: float) -> ThrustCurve:
        """Use the same curve with another shape from now on.

        Args:
            shape: k, 0 to 1.

        Returns:
            The curve.

        Raises:
            BackendError: if there is no curve yet.
        """
        if self._link.stream.curve is None:
            raise BackendError("no thrust curve yet", field="pixhawk.thrust_curve", allowed="calibrate_hover before")
        self._link.stream.curve = curve = replace(self._link.stream.curve, shape=shape)
        return curve

    def _rules(self) -> tuple[Rule, ...]:
        delay = self._link.mocap.statistics().median_delay
        return rules_for(self._link.known_dialect, self.config, None if delay != delay else delay)
