"""The Pixhawk as the mission sees it: state in, setpoints and poses out, and the steps of a flight."""

from __future__ import annotations

from dataclasses import replace

from numpy.typing import ArrayLike

from doorman.background import Opened
from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import sequences
from doorman.hardware.pixhawk.config import PixhawkConfig
from doorman.hardware.pixhawk.events import Event, Outcome
from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.link.mocap import MocapPose
from doorman.hardware.pixhawk.link.status import LinkStatus, link_status
from doorman.hardware.pixhawk.parameters import protocol as parameters
from doorman.hardware.pixhawk.parameters.protocol import Finding, prepare_attitude, side_force_missing
from doorman.hardware.pixhawk.parameters.rules import Rule, rules_for
from doorman.hardware.pixhawk.sample import SampleStatus, VehicleSample
from doorman.hardware.pixhawk.setpoints import AttitudeSetpoint, PositionSetpoint, Setpoint
from doorman.hardware.pixhawk.thrust.curve import ThrustCurve
from doorman.hardware.pixhawk.thrust.slope import Slope, ThrustModel
from doorman.hardware.pixhawk.wire.messages import mavlink

LEAST_HEIGHT, MOST_HEIGHT = 0.2, 50.0
"""Lowest and highest take-off [m]."""
_REASONS_WITHIN, _REASONS_TOGETHER = 1.0, 0.2
"""Longest wait for the first reason why it would not arm, and for further ones [s]."""
_REMEMBERED = 40.0
"""ArduPilot repeats what keeps it from arming every 30 s [s]."""


class Autopilot(Opened):
    """A PX4 or ArduPilot multirotor on a MAVLink connection. The constructor touches no device.

    `state`, `setpoint`, `mocap`, `events` and `status` never wait for the line; the steps of a flight do, with time-outs.

    Args:
        config: Settings.
        clock: Clock of all its waits.
    """

    def __init__(self, config: PixhawkConfig, clock: Clock = REAL_TIME) -> None:
        self.config, self._clock = config, clock
        self._link = Link(config, clock)

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
            sequences.await_autopilot(self._link)
        except BaseException:
            self._link.stop()
            raise

    def stop(self) -> None:
        """Land what still flies by our setpoints (`on_stop`), end the thread and close the line; may be called twice."""
        link = self._link
        try:
            if link.alive and link.identity is not None:
                sequences.leave(link)
        finally:
            link.stop()

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
        return self._link.mocap.offer(MocapPose.checked(time_of_capture, position, quaternion), self._clock.now())

    def events(self) -> tuple[Event, ...]:
        """Events since the last call, oldest first."""
        return tuple(self._link.events.take())

    def complaints(self) -> tuple[str, ...]:
        """Texts of severity warning or worse in the last 40 s, each once: the autopilot repeats those that hold."""
        return tuple(self._link.exchange.texts(self._clock.now() - _REMEMBERED, mavlink.MAV_SEVERITY_WARNING))

    def check_again(self) -> tuple[str, ...]:
        """Have the autopilot check now whether it would arm, on the ground; unasked, it says why not twice a minute.

        Returns:
            What it says to that; `complaints` if it says nothing.
        """
        started = self._clock.now()
        self._link.command(mavlink.MAV_CMD_RUN_PREARM_CHECKS, tries=2)
        self._link.until(lambda: bool(self._link.exchange.texts(started)), _REASONS_WITHIN)
        self._clock.sleep(_REASONS_TOGETHER)
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

    def engage(self, *, unarmed: bool = False) -> Outcome:
        """Enter the mode in which the autopilot obeys us: offboard or guided.

        Before, everything that attitude setpoints need is looked up: the thrust curve and ArduPilot's options.

        Args:
            unarmed: Whether a vehicle that a person has armed by then is left to this person.

        Returns:
            DONE once the heartbeat shows the mode.
        """
        self._link.known_dialect  # noqa: B018  # an error if nothing was heard
        if self.config.setpoints == "attitude":
            outcome = prepare_attitude(self._link)
            if not outcome.done:
                return outcome
        return sequences.engage(self._link, unarmed)

    def arm(self, timeout: float | None = None) -> Outcome:
        """Arm; refused, it is tried again until the time is over.

        Args:
            timeout: [s]; by default that of the settings.

        Returns:
            DONE once the heartbeat shows it; otherwise with the autopilot's reasons.
        """
        return sequences.arm(self._link, self.config.timeouts.arming if timeout is None else timeout)

    def disarm(self) -> Outcome:
        """Disarm on the ground."""
        return sequences.disarm(self._link)

    def take_off(self, height: float) -> Outcome:
        """Climb and hold.

        Args:
            height: Above where the vehicle stands [m].

        Returns:
            DONE once the height is reached.

        Raises:
            BackendError: if the height is out of range.
        """
        if not LEAST_HEIGHT <= height <= MOST_HEIGHT:
            allowed = f"{LEAST_HEIGHT:g} to {MOST_HEIGHT:g} m"
            raise BackendError("not a height", field="height", given=height, allowed=allowed)
        return sequences.take_off(self._link, height)

    def hold(self, *, at: PositionSetpoint | None = None, latch: bool = False) -> Outcome:
        """Stay where the vehicle is, or go to a place and stay there, by position setpoints.

        Args:
            at: Where; here if not given, which a position of the last second tells.
            latch: Refuse the controller's setpoints until `resume`.
        """
        return sequences.hold(self._link, at, latch)

    def resume(self) -> None:
        """Let the controller's setpoints in again after a latched hold."""
        self._link.stream.release()

    def land(self) -> Outcome:
        """Land where the vehicle is, in the autopilot's own mode.

        Returns:
            DONE once it is disarmed; CONTROL_LOST if the vehicle is not ours.
        """
        return sequences.land(self._link)

    def request_landing(self) -> bool:
        """Ask for the landing mode without waiting; asked again until the heartbeat shows it.

        Returns:
            False if the vehicle is not ours.
        """
        return self._link.request_landing()

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
        return sequences.measure_hover(self._link, hover_force, duration, compensate_battery=compensate_battery)

    def measure_slope(self, at: PositionSetpoint) -> Slope | None:
        """Measure how steeply thrust grows with its setpoint, by bobbing up and aside a little; the vehicle must hold.

        Args:
            at: Where it holds.

        Returns:
            The slope, by the thrust curve in use; None if the vehicle is not ours, or too little was heard.
        """
        return sequences.measure_slope(self._link, at)

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
