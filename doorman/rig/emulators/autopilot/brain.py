"""The emulated autopilots' rules: modes, arming, setpoints, failsafes, landing, and what they say about it.

One brain for both; where PX4 and ArduPilot differ it looks into their `Dialect`, or whether a parameter exists.
Sources: PX4 user guide, "Offboard Mode" and "Safety Configuration"; ArduCopter documents, "Guided Mode" and "Failsafes".
"""

from __future__ import annotations

import math

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.control import Demand, Task
from doorman.rig.emulators.autopilot.dialects import ACCEPTED, DENIED, UNSUPPORTED, Dialect, ParameterStore
from doorman.rig.emulators.autopilot.estimator import NOTHING, Estimate
from doorman.rig.emulators.autopilot.way_home import WayHome

_OFFBOARD_LOST = {4: "land", 5: "loiter"}
"""Mode by COM_OBL_RC_ACT without a radio; all other values return."""


class Brain:
    """Modes and rules of one autopilot. Its requests return a MAV_RESULT."""

    def __init__(
        self, dialect: Dialect, parameters: ParameterStore, now: float, estimate: Estimate, start_up: float = 0.0
    ) -> None:
        self.dialect, self.parameters = dialect, parameters
        self.mode = dialect.modes[dialect.begins]
        self.armed = self.failsafe = False
        self.landed = True
        self.refusal: str | None = None
        """Words of a refusal to arm, empty for a silent one, as PX4 gives at times; None if it is up to the rules."""
        self.texts: list[tuple[int, str]] = []  # severity and words, waiting to be sent
        self.demand, self._target = Demand(Task.IDLE), Demand(Task.VELOCITY)
        self.home, self.sticks = NOTHING, (0.0, 0.0, 0.0)
        """Where it was armed, as it was believed then [m]; and the velocity that the pilot asks for [m/s]. World frame."""
        self._now, self._estimate, self._station_age, self._start_up = now, estimate, math.inf, start_up
        self._heard_at, self._armed_at = -math.inf, now  # when the newest setpoint came, and when it was armed [s]
        self._hold: Demand | None = None
        self._return: WayHome | None = None
        self._halted_since = self._stands_since = math.inf
        """Since when a landing has stopped, and has stood on the ground [s]."""
        self._lost_at = self._killed_at = math.inf
        """When the stream ended that it needs, and when a switch stopped its motors [s]."""
        self._goes_back = False  # whether it left `companion` for want of setpoints: it is back as soon as they are

    def is_in(self, *names: str) -> bool:
        return self.mode in [self.dialect.modes[name] for name in names]

    # ------------------------------------------------------------ requests

    def request_mode(self, mode: int) -> int:
        """Answer DO_SET_MODE. PX4 accepts it on the ground even where the mode does not change: the heartbeat tells."""
        if mode not in self.dialect.modes.values():
            return DENIED
        if self._available(mode):
            self._enter(mode)
            return ACCEPTED
        return ACCEPTED if self.dialect.heeds_stream and not self.armed else self.dialect.refusal

    def request_land(self) -> int:
        self._enter(self.dialect.modes["land"])
        return ACCEPTED

    def request_take_off(self, height: float) -> int:
        """Answer NAV_TAKEOFF: accepted only from the ground, armed, in `companion`."""
        if not self.dialect.lifts_off_by_command:
            return UNSUPPORTED
        if not self.is_in("companion") or not self.armed or not self.landed or not 0.0 < height < math.inf:
            return self.dialect.refusal
        place = np.array([*self._estimate.position[:2], self.home[2] + height])
        self._target = self.demand = Demand(Task.POSITION, position=place, yaw=self._estimate.yaw)
        self.landed = False
        return ACCEPTED

    def request_arming(self, arm: bool, forced: bool) -> int:
        if not arm:
            if self.armed and not self.landed and not forced:
                return self.dialect.refusal
            self.disarm()
        elif not self.armed:
            if self.arming_refused():
                return self.dialect.refusal
            self.armed, self._armed_at, self.home = True, self._now, self._estimate.position
        return ACCEPTED

    def arming_refused(self) -> bool:
        """Whether a request to arm would be refused now; it says why by STATUSTEXT."""
        reason = self._against_arming()
        if reason:
            self._say(reason)
        return reason is not None

    def pilot_mode(self, name: str) -> None:
        """Turn the pilot's mode switch: it wins, and ends a failsafe, where the mode is available."""
        if name not in self.dialect.modes:
            raise ValueError(f"unknown mode {name}: {', '.join(self.dialect.modes)}")
        if self._available(self.dialect.modes[name]):
            self.failsafe = False
            self._enter(self.dialect.modes[name])

    def kill(self, stop: bool) -> None:
        self._killed_at = self._now if stop and self.armed else math.inf

    @property
    def killed(self) -> bool:
        """Whether a switch of the radio has stopped the motors; it stays armed in its mode for a while."""
        return self._killed_at < math.inf

    def disarm(self) -> None:
        self.armed = self.failsafe = False
        self._killed_at = math.inf

    def aim(self, demand: Demand | None) -> None:
        heard = self.dialect.heeds_stream or (self.is_in("companion") and self.armed)
        if heard and not (demand is None and self.dialect.heeds_stream):
            self._target, self._heard_at = demand or Demand(Task.VELOCITY), self._now

    # ------------------------------------------------------------ every step

    def update(self, now: float, estimate: Estimate, on_ground: bool, station_age: float) -> Demand:
        self._now, self._estimate, self._station_age = now, estimate, station_age
        self._watch_ground(on_ground)
        if self.armed:
            self._watch_links()
        demand = self._decide()
        if now - self._killed_at > self.dialect.killed_for:
            self.disarm()
        self.demand = demand if self.armed and not self.killed else Demand(Task.IDLE)
        return self.demand

    def _watch_ground(self, on_ground: bool) -> None:
        """It is landed on the ground, or stuck in a landing, and not about to leave; a landing that has stood is over."""
        task = self.demand.task
        halted = self.armed and task is Task.LAND and abs(float(self._estimate.velocity[2])) <= self.dialect.standing
        self._halted_since = min(self._halted_since, self._now) if halted else math.inf
        down = on_ground or self._now - self._halted_since > self.dialect.land_detection
        self.landed = down and (task in (Task.IDLE, Task.LAND) or not self.armed or self.landed)
        stands = self.armed and self.landed and task is Task.LAND
        self._stands_since = min(self._stands_since, self._now) if stands else math.inf
        if self._now - self._stands_since > self.parameters.get("COM_DISARM_LAND", self.dialect.land_detection):
            self.disarm()

    def _decide(self) -> Demand:
        if self.is_in("companion"):
            return self._follow()
        if self.is_in("land") or (self.is_in("return") and not self._estimate.on_earth):
            return Demand(Task.LAND)
        if self.is_in("return"):
            return self._way_home().demand(self._estimate, self._now)
        return self._wait() if self.landed else self._hold_here()

    def _follow(self) -> Demand:
        """Obey the newest setpoint."""
        target, height = self._target, float(self._estimate.position[2])
        if target.task is not Task.POSITION and self._now - self._heard_at > self.parameters.get(
            "GUID_TIMEOUT", math.inf
        ):
            target = Demand(Task.VELOCITY)
        if self.landed:
            if target.task is Task.POSITION:
                rises = not self.dialect.lifts_off_by_command and target.position[2] > height + self.dialect.off_ground
            else:
                rises = target.thrust > self.parameters[self.dialect.hover_thrust]
            if not rises:
                return self._wait()
            self.landed = False
        return target

    def _wait(self) -> Demand:
        """Stand on the ground; who does not take off is disarmed."""
        if self.armed and self._now - self._armed_at > self.parameters[self.dialect.disarm_after]:
            self.disarm()
        return Demand(Task.IDLE)

    def _hold_here(self) -> Demand:
        """Stay at the place where this was first asked for, or follow the pilot's sticks."""
        if self.is_in("position") and any(self.sticks):
            self._hold = None
            return Demand(Task.VELOCITY, velocity=np.array(self.sticks))
        if self._hold is None:
            self._hold = Demand(Task.POSITION, position=self._estimate.position, yaw=self._estimate.yaw)
        return self._hold

    def _way_home(self) -> WayHome:
        """At the height of its parameter, or as high as it is."""
        if self._return is None:
            name, unit = self.dialect.return_height
            height = max(float(self.home[2]) + unit * self.parameters[name], float(self._estimate.position[2]))
            self._return = WayHome(self.home, self._estimate, self._now, height)
        return self._return

    # ------------------------------------------------------------ failsafes

    def _watch_links(self) -> None:
        if self.dialect.heeds_stream:
            self._watch_stream()
        action, timeout, actions = self.dialect.station
        wanted = actions.get(int(self.parameters[action]))
        lost = self.parameters[timeout] < self._station_age < math.inf
        if wanted is not None and lost and not self.is_in("land", "return"):
            self._fail("Failsafe: no ground station", wanted)
        if not self._estimate.position_valid and self.is_in(*self.dialect.positioned):
            self._fail("Failsafe: position lost", "land")

    def _watch_stream(self) -> None:
        """Without setpoints PX4 does what COM_OBL_RC_ACT says, until they come again."""
        if self._goes_back and self._stream_available():
            self.failsafe = False
            self._enter(self.dialect.modes["companion"])
        if not self.is_in("companion") or self._stream_available():
            self._lost_at = math.inf
            return
        self._lost_at = min(self._lost_at, self._now)
        if self._now - self._lost_at > self.dialect.failsafe_delay:
            action = _OFFBOARD_LOST.get(int(self.parameters["COM_OBL_RC_ACT"]), "return")
            self._fail("Failsafe: no offboard signal", action if self._estimate.position_valid else "land")
            self._goes_back = True

    def _stream_available(self) -> bool:
        """Whether a setpoint is newer than COM_OF_LOSS_T: a single one is enough (PX4 1.17, `offboardCheck`)."""
        fresh = self._now - self._heard_at <= self.parameters["COM_OF_LOSS_T"]
        return fresh and (self._estimate.position_valid or self._target.task is Task.ATTITUDE)

    def _available(self, mode: int) -> bool:
        modes = self.dialect.modes
        available = self._estimate.on_earth or mode not in [modes[name] for name in self.dialect.placed]
        if self.dialect.heeds_stream and mode == modes["companion"]:
            available = self._stream_available()
        if not available:
            self._say("Switching to that mode is currently not available")
        return available

    def _against_arming(self) -> str | None:
        """Why it would not arm now, empty if it does not say so; None if it would."""
        action, timeout, _ = self.dialect.station
        if self.refusal is not None:
            return self.refusal
        if self._now < self._start_up:
            return "PreArm: Gyros not calibrated"
        if self.dialect.heeds_stream and self.parameters[action] > 0 and self._station_age > self.parameters[timeout]:
            return "Preflight Fail: No connection to the GCS"
        if self.dialect.heeds_stream and self.is_in("companion") and not self._stream_available():
            return "Arming denied: no offboard signal"
        return None if self._estimate.position_valid else "PreArm: Need Position Estimate"

    def _say(self, text: str) -> None:
        self.texts.append((mavlink.MAV_SEVERITY_CRITICAL, text))

    def _fail(self, text: str, mode: str) -> None:
        self.failsafe = True
        self._say(text)
        self._enter(self.dialect.modes[mode])

    def _enter(self, mode: int) -> None:
        if mode != self.mode:
            self._hold = self._return = None
        self.mode, self._goes_back, self._lost_at = mode, False, math.inf
        if not self.dialect.heeds_stream:
            self._target = Demand(Task.VELOCITY)
