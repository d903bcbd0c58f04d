"""One cycle on the bus: read all servos, judge them, command them within their limits, and revive watchdogs that fired."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from doorman.arrays import frozen
from doorman.background import EventLog
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import registers as reg
from doorman.hardware.dynamixel.commissioning import ReadyServo, arm_watchdog, commission
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import LATCHED, STOPPING, BusState, ServoEvent, ServoFault, ServoSample
from doorman.hardware.dynamixel.link import UNANSWERED, Link, ServoReader
from doorman.hardware.dynamixel.monitor import ServoMonitor
from doorman.hardware.dynamixel.port import PortLost
from doorman.hardware.dynamixel.registers import Telemetry, Unit, joint_angle
from doorman.hardware.dynamixel.settings import Servo

_ILL = STOPPING | LATCHED
_UNHEARD = UNANSWERED | ServoFault.LATE | ServoFault.REFUSED


@dataclass(frozen=True)
class ServoCommand:
    rates: tuple[float, ...]  # of the joints, shape (n_joints,) [rad/s]
    current: float  # of the gripper, positive where it pushes the angle up [A]
    time: float  # when it did [s]
    grip_time: float  # when it asked for this current; later ones went on with it [s]


class ServoCycle:
    """What the adapter knows of its servos, and what it does with them once in a period."""

    def __init__(
        self, link: Link, ready: tuple[ReadyServo, ...], config: ServoConfig, log: EventLog[ServoEvent]
    ) -> None:
        self._config, self._log = config, log
        self.ready = list(ready)
        self._governor = RateGovernor(config, self.ready)
        self._goals = [0.0] * config.n_joints
        self._logged = [ServoFault.NONE] * (config.n + 1)  # of every servo, and of the bus
        self.monitors = [ServoMonitor(config, link.now(), servo.model, joint) for joint, servo in enumerate(ready)]
        self.bus_fault = ServoFault.NONE  # what is wrong with the bus itself
        self.count = 0  # cycles until now
        self.use(link)

    def use(self, link: Link) -> None:
        """Go on over another link, as after the device was plugged in again."""
        self._link = link
        self._released = link.now()
        self.reader = ServoReader(link, self._config)

    def recover(self, deadline: float, breathe: Callable[[], None]) -> list[str]:
        """Set up again every servo that is missing or has a latched fault, with a reboot if it has shut down; what failed."""
        # The arm stands still meanwhile.
        failures = []
        for joint, monitor in enumerate(self.monitors):
            if not monitor.fault & (LATCHED | ServoFault.MISSING):
                continue
            self.reader.excluded = joint
            servo = Servo(self._link, self._config, joint, deadline, breathe)
            try:
                ready = commission(servo, self._log, write_eeprom=False)
                arm_watchdog(servo)
            except PortLost:
                raise
            except BackendError as error:
                failures.append(str(error))
                self._note(joint, f"not recovered: {error}")
            else:  # it is well until it says otherwise
                self.ready[joint] = ready
                monitor.recovered()
                self.reader.absent.discard(joint)
                self._note(joint, "set up again")
            finally:
                self.reader.excluded = None
        if not failures:
            self.bus_fault &= ~ServoFault.INTERNAL
        return failures

    def _note(self, joint: int, text: str) -> None:
        self._log.write(ServoEvent(self._link.now(), self._config.ids[joint], ServoFault.NONE, True, text))

    def listen(self) -> bool:
        for joint, reply in self.reader.read().items():
            self.monitors[joint].take(reply)
            if reply.ok and joint in self.reader.absent:
                self._welcome_back(joint)
        return all(monitor.telemetry is not None for monitor in self.monitors)

    def step(self, command: ServoCommand | None) -> ServoSample:
        self.count += 1
        self.listen()
        now = self._link.now()
        self.bus_fault &= ~ServoFault.COMMAND_STALE
        if command is not None and any(command.rates) and now - command.time > self._config.command_timeout:
            self.bus_fault |= ServoFault.COMMAND_STALE
        faults = self._faults()
        self._report(now, faults)
        bus_ill = bool(self.bus_fault & _ILL)
        holding = bus_ill or any(fault & _ILL for fault in faults)
        if bus_ill or command is None:
            counts = self._governor.halt()
        else:
            rates = [0.0] * self._config.n_joints if holding else command.rates
            ages = [now - monitor.time for monitor in self.monitors]
            counts = self._governor.counts(rates, self._angles(), ages)
        self._send(counts)
        if self._config.gripper and command is not None:
            self._grip(self._wanted_current(command, now))
        sample = self.sample(BusState.HOLDING if holding else BusState.FOLLOWING)
        self._loosen_one()
        self._revive_one()
        return sample

    def halt(self) -> None:
        """Command zero velocity to all joints, and no current to the gripper, which its spring opens then."""
        self._send(self._governor.halt())
        if self._config.gripper:
            self._grip(0.0)

    def sample(self, state: BusState) -> ServoSample:
        """What is known of all servos, each entry with the time of its own measurement."""
        rows, signs = self._rows(), self._config.signs
        times = frozen([monitor.time for monitor in self.monitors])
        units = [servo.current_unit for servo in self.ready]
        return ServoSample(
            time=float(times.min()),
            angles=frozen(self._angles()),
            rates=frozen([sign * row.velocity * Unit.VELOCITY for sign, row in zip(signs, rows, strict=True)]),
            currents=frozen([sign * row.current * unit for sign, row, unit in zip(signs, rows, units, strict=True)]),
            temperatures=frozen([row.temperature for row in rows]),
            voltages=frozen([row.voltage * Unit.VOLTAGE for row in rows]),
            errors=tuple(row.hardware_error for row in rows), times=times, faults=tuple(self._faults()),
            bus_fault=self.bus_fault, state=state, goals=frozen(self._goals), cycle=self.count, age=0.0, fresh=False,
        )  # fmt: skip

    def _rows(self) -> list[Telemetry]:
        rows = [monitor.telemetry for monitor in self.monitors if monitor.telemetry is not None]
        assert len(rows) == self._config.n, "a cycle begins after every servo was heard"
        return rows

    def _angles(self) -> list[float]:
        config = self._config
        return [
            joint_angle(row.position, zero, sign) + ready.turns
            for row, zero, sign, ready in zip(self._rows(), config.zeros, config.signs, self.ready, strict=True)
        ]

    def _faults(self) -> list[ServoFault]:
        lower, upper, _ = self._config.limits
        faults = []
        for joint, angle in enumerate(self._angles()):
            outside = max(lower[joint] - angle, angle - upper[joint]) > self._config.limit_tolerance
            fault = self.monitors[joint].fault
            faults.append(fault | ServoFault.OUT_OF_LIMITS if outside else fault)
        return faults

    def _report(self, now: float, faults: list[ServoFault]) -> None:
        """Write one event for every fault that began or ended."""
        self.reader.absent.update(joint for joint, fault in enumerate(faults) if fault & ServoFault.MISSING)
        whole = [*faults, self.bus_fault]
        for who, before, after in zip((*self._config.ids, None), self._logged, whole, strict=True):
            for fault in before ^ after if before != after else ():
                name, began = str(fault.name).lower().replace("_", " "), bool(fault & after)
                self._log.write(ServoEvent(now, who, fault, began, f"{name} {'began' if began else 'ended'}"))
        self._logged = whole

    def _send(self, counts: list[int]) -> None:
        n = self._config.n_joints
        self._link.sync_write(reg.GOAL_VELOCITY, dict(zip(self._config.ids[:n], counts, strict=True)))
        self._goals = [sign * count * Unit.VELOCITY for sign, count in zip(self._config.signs[:n], counts, strict=True)]

    def _wanted_current(self, command: ServoCommand, now: float) -> float:
        gripper = self.monitors[-1]
        failed = gripper.latched or gripper.fault & ServoFault.WATCHDOG or self.bus_fault & ServoFault.INTERNAL
        if failed or self.reader.excluded == self._config.n_joints:
            self._released = now
        return command.current if command.grip_time > self._released else 0.0

    def _grip(self, current: float) -> None:
        servo = self.ready[-1]
        limit = servo.current_limit
        counts = self._config.signs[-1] * round(current / servo.current_unit)
        self._link.sync_write(reg.GOAL_CURRENT, {self._config.ids[-1]: min(max(counts, -limit), limit)})

    def _welcome_back(self, joint: int) -> None:
        """Read a servo together with the others again, unless another model answers in its place."""
        answer = self._link.ping(self._config.ids[joint])
        if answer.ok and int.from_bytes(answer.data[:2], "little") == self.ready[joint].model:
            self.reader.absent.discard(joint)
        elif answer.ok:
            self.monitors[joint].condemn(ServoFault.WRONG_MODEL)

    def _loosen_one(self) -> None:
        """Take the torque of one servo that does not know its angle: as delivered it keeps it, and obeys no stop."""
        for joint, monitor in enumerate(self.monitors):
            lost = monitor.latched & ServoFault.ENCODER and not monitor.fault & (ServoFault.TORQUE_OFF | _UNHEARD)
            if lost and joint != self.reader.excluded:
                self._link.write(self._config.ids[joint], reg.TORQUE_ENABLE, reg.TORQUE_OFF)
                return

    def _revive_one(self) -> None:
        """Set the watchdog of one servo again whose watchdog has fired: it refused our zeros, and may have kept its goal."""
        for joint, monitor in enumerate(self.monitors):
            if not monitor.fault & ServoFault.WATCHDOG or monitor.fault & _UNHEARD or joint == self.reader.excluded:
                continue
            write, servo_id = self._link.write, self._config.ids[joint]
            goal = reg.GOAL_VELOCITY if joint < self._config.n_joints else reg.GOAL_CURRENT
            self._link.clear_watchdog(servo_id, goal)
            cleared = write(servo_id, reg.BUS_WATCHDOG, reg.WATCHDOG_OFF).ok
            cleared = write(servo_id, goal, 0).ok and cleared
            if cleared and write(servo_id, reg.BUS_WATCHDOG, self._config.watchdog_counts).ok:
                self._note(joint, "bus watchdog cleared and set again")
            return


def stopping_rate(distance: float, deceleration: float, delay: float) -> float:
    if not distance > 0.0:
        return 0.0
    return deceleration * (math.sqrt(delay * delay + 2.0 * distance / deceleration) - delay)


def allowed_rate(
    wanted: float, angle: float, lower: float, upper: float, largest: float, deceleration: float, delay: float
) -> float:
    """Rate that a joint may have: what is wanted, inside its rate limit, and so that it can stop at its limits."""
    if not (math.isfinite(wanted) and math.isfinite(angle)):
        return 0.0
    up = min(stopping_rate(upper - angle, deceleration, delay), largest)
    down = min(stopping_rate(angle - lower, deceleration, delay), largest)
    return max(min(wanted, up), -down)


class RateGovernor:
    def __init__(self, config: ServoConfig, servos: Sequence[ReadyServo]) -> None:
        self._config, self._servos = config, servos
        self._rests = [0.0] * config.n_joints  # of every joint's rate, which no whole count has made up for [count]

    def counts(self, rates: Sequence[float], angles: Sequence[float], ages: Sequence[float]) -> list[int]:
        config, counts = self._config, []
        lower, upper, fastest = config.limits
        for joint in range(config.n_joints):
            largest = min(math.floor(float(fastest[joint]) / Unit.VELOCITY), self._servos[joint].velocity_limit)
            rate = allowed_rate(
                rates[joint], angles[joint], float(lower[joint]) + config.limit_margin,
                float(upper[joint]) - config.limit_margin, largest * Unit.VELOCITY, config.deceleration,
                config.reaction_time + ages[joint],
            )  # fmt: skip
            counts.append(config.signs[joint] * max(min(self._rounded(joint, rate), largest), -largest))
        return counts

    def halt(self) -> list[int]:
        """Goal velocities of a stop; nothing is carried over it."""
        self._rests = [0.0] * len(self._rests)
        return [0] * len(self._rests)

    def _rounded(self, joint: int, rate: float) -> int:
        """Whole counts of a rate. What is left goes into the next cycle, so that a slow joint keeps its mean rate."""
        if rate == 0.0:
            self._rests[joint] = 0.0
            return 0
        wanted = rate / Unit.VELOCITY + self._rests[joint]
        counts = round(wanted)
        self._rests[joint] = max(min(wanted - counts, 0.5), -0.5)
        return counts if counts * rate > 0.0 else 0
