"""ArduCopter's rules: guided needs no stream, lifts off by command, and takes thrust for a climb rate unless told otherwise."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.brain import (
    ACCEPTED,
    DENIED,
    FAILED,
    AttitudeTarget,
    Brain,
    PositionTarget,
    Surroundings,
)
from doorman.rig.emulators.autopilot.control import Demand, Task
from doorman.rig.emulators.autopilot.parameters import ParameterStore
from doorman.rig.emulators.autopilot.plant import thrust_axis, yaw_of
from doorman.rig.emulators.autopilot.way_home import Return

STABILIZE, ALTITUDE_HOLD, GUIDED, LOITER, RETURN, LAND = 0, 2, 4, 5, 6, 9
_NAMES = {"stabilize": STABILIZE, "altitude": ALTITUDE_HOLD, "guided": GUIDED, "loiter": LOITER, "position": LOITER,
          "return": RETURN, "land": LAND}  # fmt: skip
_NEED_POSITION = (GUIDED, LOITER, RETURN)
_CLIMB_SPEED, _DESCENT_SPEED = 2.5, 1.5
_STOPPING, _SLOW_SHARE = 0.05, 0.1
"""A take-off is over within this distance [m], at less than this share of the climb speed."""
_UNIT_TOLERANCE = 1e-3
_LEAST_RETURN, _LEAST_SLOPE = 0.3, 0.5
"""Height of a return above home [m]; a flatter cone is none."""
_FAILSAFE_ACTIONS = {1: RETURN, 2: RETURN, 3: RETURN, 4: LAND, 5: LAND, 6: RETURN, 7: LOITER}
"""Of FS_GCS_ENABLE; the last brakes, and then only hovers."""
_GO_ON_LANDING = 8
"""Of FS_OPTIONS: a landing goes on whatever link is lost."""
_FACES_HOME = (1, 3)
"""Of WP_YAW_BEHAVIOR."""


class ArduPilotBrain(Brain):
    """ArduCopter.

    Args:
        parameters: Its parameters.
        start_up: Until the gyros are calibrated [s].
    """

    vendor = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    stick_mode = LOITER
    heeds_force = True

    def __init__(self, parameters: ParameterStore, start_up: float) -> None:
        super().__init__(parameters)
        self.mode = STABILIZE
        self._start_up = start_up
        self._target = Demand(Task.VELOCITY)
        self._target_time = 0.0
        self._taking_off_to: float | None = None

    @property
    def refused_result(self) -> int:
        """ArduPilot says "failed"."""
        return FAILED

    @property
    def disarm_delay(self) -> float:
        """The land detector's."""
        return 1.0

    @property
    def taking_off(self) -> bool:
        """Between NAV_TAKEOFF and whatever comes next."""
        return self._taking_off_to is not None

    def request_mode(self, parameters: Sequence[float]) -> int:
        """Refused where the mode needs a position that is not known."""
        if not int(parameters[0]) & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
            return DENIED
        mode = int(parameters[1])
        valid = self.around is not None and self.around.estimate.position_valid
        if mode not in _NAMES.values() or (mode in _NEED_POSITION and not valid):
            self.say(mavlink.MAV_SEVERITY_WARNING, "Mode change failed: requires position")
            return FAILED
        self._enter(mode)
        return ACCEPTED

    def request_take_off(self, height: float) -> int:
        """Only from the ground, armed, in guided."""
        if self.mode != GUIDED or not self.armed or not self.landed or height <= 0.0:
            return FAILED
        self._taking_off_to = float(self.home.position[2]) + height
        self._hold = None
        return ACCEPTED

    def request_land(self) -> int:
        """Land here."""
        self._enter(LAND)
        return ACCEPTED

    def request_return(self) -> int:
        """RTL."""
        return self.request_mode((mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, RETURN, 0))

    def attitude_target(self, target: AttitudeTarget) -> None:
        """Obeyed in guided only; a quaternion off unit length stops the vehicle."""
        if self.mode != GUIDED or not self.armed or self.around is None:
            return
        norm = float(np.linalg.norm(target.quaternion))
        rates_ignored = target.mask & 7 == 7
        unit = abs(norm - 1.0) <= _UNIT_TOLERANCE
        if target.mask & 0x40 or not rates_ignored or not unit or not math.isfinite(target.thrust):
            self._stop()
            return
        if int(self.parameters["GUID_OPTIONS"]) & 8:
            demand = Demand(Task.ATTITUDE, quaternion=target.quaternion, thrust=self._boosted(target))
            lifts = target.thrust > 0.0
        else:
            share = 2.0 * (min(max(target.thrust, 0.0), 1.0) - 0.5)
            rate = share * (_CLIMB_SPEED if share > 0.0 else _DESCENT_SPEED)
            demand = Demand(Task.CLIMB_RATE, quaternion=target.quaternion, climb_rate=rate)
            lifts = rate > 0.0
        if self.landed and lifts:
            self.landed = False
        self._aim(demand)

    def position_target(self, target: PositionTarget) -> None:
        """Obeyed in guided only; it also ends a take-off."""
        if self.mode != GUIDED or not self.armed:
            return
        used = [target.position] * target.has_position + [target.velocity] * target.has_velocity
        used += [target.acceleration] * target.has_acceleration
        allowed = target.has_velocity or (target.has_position and not target.has_acceleration)
        if target.frame != mavlink.MAV_FRAME_LOCAL_NED or not allowed or not np.isfinite(np.concatenate(used)).all():
            self._stop()
            return
        zero = np.zeros(3)
        demand = Demand(
            Task.POSITION if target.has_position else Task.VELOCITY,
            position=target.position if target.has_position else zero,
            velocity=target.velocity if target.has_velocity else zero,
            acceleration=target.acceleration if target.has_acceleration and target.has_velocity else zero,
            yaw=None if target.mask & 0x400 or not math.isfinite(target.yaw) else target.yaw,
        )
        self._aim(demand)

    def pilot_mode(self, name: str) -> None:
        """The pilot turns the mode switch: it always wins."""
        if name not in _NAMES:
            raise ValueError(f"unknown mode {name}: {', '.join(_NAMES)}")
        self._enter(_NAMES[name])

    def _enter(self, mode: int) -> None:
        super()._enter(mode)
        self._taking_off_to = None
        self._stop()

    def _stop(self) -> None:
        self._aim(Demand(Task.VELOCITY))

    def _aim(self, demand: Demand) -> None:
        self._target, self._taking_off_to = demand, None
        self._target_time = 0.0 if self.around is None else self.around.now

    def _boosted(self, target: AttitudeTarget) -> float:
        """Thrust over the cosine of the commanded tilt, unless that is switched off."""
        thrust = min(max(target.thrust, 0.0), 1.0)
        if not self.parameters["ATC_ANGLE_BOOST"]:
            return thrust
        return min(1.0, thrust / min(max(float(thrust_axis(target.quaternion)[2]), 0.1), 1.0))

    def _arming_refused(self, forced: bool) -> tuple[int, str] | None:
        around = self.around
        assert around is not None
        if forced:
            lost = self.mode in _NEED_POSITION and not around.estimate.position_valid
            return (FAILED, "Arm: Need Position Estimate") if lost else None
        if around.now < self._start_up:
            return FAILED, "PreArm: Gyros not calibrated"
        if not around.estimate.position_valid:
            return FAILED, "PreArm: Need Position Estimate"
        if self.mode in (RETURN, LAND):
            return FAILED, "Arm: Mode not armable"
        return None

    def _decide(self, around: Surroundings) -> Demand:
        if self.armed:
            self._watch_links(around)
        if self.mode == LAND:
            return Demand(Task.LAND)
        if self.mode == RETURN:
            return self.return_home(around)
        if self.mode == GUIDED:
            return self._guided(around)
        return self._on_ground(around) if self.landed else self.hold_here(around)

    def _begin_return(self, around: Surroundings) -> Return:
        """Near home it climbs no higher than a cone whose slope is RTL_CONE_SLOPE; with RTL_ALT_FINAL it stays in the air."""
        values, floor = self.parameters, float(self.home.position[2])
        least = max(
            _LEAST_RETURN, float(around.estimate.position[2]) - floor + 0.01 * max(values["RTL_CLIMB_MIN"], 0.0)
        )
        height = max(0.01 * values["RTL_ALT"], least)
        if values["RTL_CONE_SLOPE"] >= _LEAST_SLOPE:
            height = min(height, max(values["RTL_CONE_SLOPE"] * self.home.distance(around.estimate.position), least))
        faces_home = values["WP_YAW_BEHAVIOR"] in _FACES_HOME
        return Return(
            self.home,
            around.estimate,
            around.now,
            floor + height,
            math.inf if values["RTL_ALT_FINAL"] > 0.0 else 1e-3 * values["RTL_LOIT_TIME"],
            self.home.bearing(around.estimate.position) if faces_home else None,
        )

    def _guided(self, around: Surroundings) -> Demand:
        if self._taking_off_to is not None:
            self.landed = False
            hold = self.hold_here(around)
            place = hold.position.copy()
            place[2] = self._taking_off_to
            demand = Demand(Task.POSITION, position=place, yaw=hold.yaw)
            left, rate = place[2] - around.estimate.position[2], around.estimate.velocity[2]
            if left < _STOPPING and rate < _SLOW_SHARE * _CLIMB_SPEED:
                self._aim(demand)
            return demand
        if self.landed:
            return self._on_ground(around)
        target, age = self._target, around.now - self._target_time
        if age <= self.parameters["GUID_TIMEOUT"] or target.task is Task.POSITION:
            return target
        if target.task is Task.VELOCITY:
            return Demand(Task.VELOCITY)
        yaw = yaw_of(target.quaternion)
        level = np.array([math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)])
        return Demand(Task.CLIMB_RATE, quaternion=level)

    def _on_ground(self, around: Surroundings) -> Demand:
        if self.armed and around.now - self._armed_at > self.parameters["DISARM_DELAY"]:
            self._disarm()
        return Demand(Task.IDLE)

    def _watch_links(self, around: Surroundings) -> None:
        action = int(self.parameters["FS_GCS_ENABLE"])
        heard_once = around.ground_station_age < float("inf")
        lost = heard_once and around.ground_station_age > self.parameters["FS_GCS_TIMEOUT"]
        goes_on = self.mode == RETURN or (self.mode == LAND and int(self.parameters["FS_OPTIONS"]) & _GO_ON_LANDING)
        if action in _FAILSAFE_ACTIONS and lost and not goes_on and self.mode != _FAILSAFE_ACTIONS[action]:
            self._fail("GCS Failsafe", _FAILSAFE_ACTIONS[action])
        if not around.estimate.position_valid and self.mode in _NEED_POSITION:
            self._fail("EKF Failsafe: changed to LAND Mode", LAND)

    def _fail(self, text: str, mode: int) -> None:
        self.failsafe = True
        self.say(mavlink.MAV_SEVERITY_CRITICAL, text)
        self._enter(mode)

    def _disarm(self) -> None:
        super()._disarm()
        self.failsafe = False
