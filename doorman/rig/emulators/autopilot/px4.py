"""PX4's rules: offboard lives by its stream; what happens without it says COM_OBL_RC_ACT (PX4 user guide, offboard mode)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.brain import (
    ACCEPTED,
    DENIED,
    TEMPORARILY_REJECTED,
    AttitudeTarget,
    Brain,
    PositionTarget,
    Surroundings,
)
from doorman.rig.emulators.autopilot.control import Demand, Task
from doorman.rig.emulators.autopilot.parameters import ParameterStore
from doorman.rig.emulators.autopilot.plant import yaw_of
from doorman.rig.emulators.autopilot.way_home import Return

MANUAL, ALTITUDE, POSITION, OFFBOARD, STABILIZED = 1 << 16, 2 << 16, 3 << 16, 6 << 16, 7 << 16
TAKE_OFF, LOITER, RETURN, LAND = (4 << 16 | sub << 24 for sub in (2, 3, 5, 6))
_NAMES = {"manual": MANUAL, "altitude": ALTITUDE, "position": POSITION, "stabilized": STABILIZED,
          "loiter": LOITER, "return": RETURN, "land": LAND, "offboard": OFFBOARD}  # fmt: skip
_LOSS_ACTIONS = {0: RETURN, 1: RETURN, 2: RETURN, 3: RETURN, 4: LAND, 5: LOITER}
"""Of COM_OBL_RC_ACT without a radio: the modes that need one become a return."""
_NEED_HOME = (LOITER, RETURN)
"""Modes that need a place on earth."""
_YAW_FIXED = 5
_FAILSAFE_DELAY = 0.1


class Px4Brain(Brain):
    """PX4 multicopter.

    Args:
        parameters: Its parameters.
    """

    vendor = mavlink.MAV_AUTOPILOT_PX4
    stick_mode = POSITION

    def __init__(self, parameters: ParameterStore) -> None:
        super().__init__(parameters)
        self.mode = LOITER
        self._heard_at, self._needs_position = -math.inf, False
        """When the newest setpoint came [s], and whether it needs a position."""
        self._target = Demand(Task.IDLE)
        self._lost_at: float | None = None
        self._told_frame: int | None = None
        self._goes_back = False
        """Whether it left offboard for want of setpoints: it is back as soon as they are."""

    @property
    def refused_result(self) -> int:
        """PX4 says "temporarily rejected"."""
        return TEMPORARILY_REJECTED

    @property
    def disarm_delay(self) -> float:
        """COM_DISARM_LAND."""
        return self.parameters["COM_DISARM_LAND"]

    @property
    def taking_off(self) -> bool:
        """In its own mode for that."""
        return self.mode == TAKE_OFF

    def request_mode(self, parameters: Sequence[float]) -> int:
        """Disarmed, accepted even where the mode does not change: the heartbeat tells."""
        if not int(parameters[0]) & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
            return DENIED
        main, sub = int(parameters[1]), int(parameters[2])
        mode = main << 16 | (sub << 24 if main == 4 else 0)
        if mode == TAKE_OFF:
            return self.request_take_off(math.nan)
        if mode not in _NAMES.values():
            return DENIED
        if self._available(mode):
            self._enter(mode)
            return ACCEPTED
        return TEMPORARILY_REJECTED if self.armed else ACCEPTED

    def _available(self, mode: int) -> bool:
        if mode == OFFBOARD:
            if not self._stream_available():
                self.say(mavlink.MAV_SEVERITY_CRITICAL, "Switching to Offboard is currently not available")
                return False
            return True
        if mode not in _NEED_HOME or (self.around is not None and self.around.estimate.on_earth):
            return True
        self.say(mavlink.MAV_SEVERITY_CRITICAL, "Switching to that mode is currently not available")
        return False

    def request_take_off(self, height: float) -> int:
        """Climb to the height, of its local frame, and loiter; no number is MIS_TAKEOFF_ALT above here."""
        if self.around is None or (self.armed and not self.around.estimate.position_valid):
            return TEMPORARILY_REJECTED
        place = self.around.estimate.position.copy()
        if not math.isfinite(height):
            height = float(place[2]) + self.parameters["MIS_TAKEOFF_ALT"]
        if height < place[2]:
            self.say(mavlink.MAV_SEVERITY_CRITICAL, "Already higher than takeoff altitude")
        place[2] = max(height, float(place[2]))
        self._enter(TAKE_OFF)
        self._hold = Demand(Task.POSITION, position=place, yaw=yaw_of(self.around.estimate.quaternion))
        return ACCEPTED

    def request_return(self) -> int:
        """AUTO_RTL."""
        return self.request_mode((mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, RETURN >> 16 & 0xFF, RETURN >> 24))

    def request_land(self) -> int:
        """Land here."""
        self._enter(LAND)
        return ACCEPTED

    def attitude_target(self, target: AttitudeTarget) -> None:
        """Heard in every mode, obeyed in offboard."""
        if (
            target.mask & 0x80
            or not np.isfinite([*target.quaternion, target.thrust, *target.thrust_body]).all()
            or not target.quaternion.any()
        ):
            return
        self._heard(needs_position=False)
        quaternion = target.quaternion / np.linalg.norm(target.quaternion)
        x, y, z = target.thrust_body if target.mask & 0x20 else (0.0, 0.0, target.thrust)
        self._target = Demand(Task.ATTITUDE, quaternion=quaternion, thrust=min(max(z, 0.0), 1.0), side=(x, y))

    def position_target(self, target: PositionTarget) -> None:
        """Heard in every mode, obeyed in offboard; BODY_NED has a velocity along the heading, other frames are dropped."""
        if target.frame == mavlink.MAV_FRAME_BODY_NED and self.around is not None:
            target = _along_heading(target, yaw_of(self.around.estimate.quaternion))
        elif target.frame != mavlink.MAV_FRAME_LOCAL_NED:
            if target.frame != self._told_frame:  # the real one repeats it
                words = f"SET_POSITION_TARGET coordinate frame {target.frame} unsupported"
                self.say(mavlink.MAV_SEVERITY_CRITICAL, words)
            self._told_frame = target.frame
            return
        if not (target.has_position or target.has_velocity):
            return
        used = [target.position] * target.has_position + [target.velocity] * target.has_velocity
        if not np.isfinite(np.concatenate(used)).all():
            return
        accelerates = target.has_acceleration and bool(np.isfinite(target.acceleration).all())
        self._heard(needs_position=True)
        zero = np.zeros(3)
        self._target = Demand(
            Task.POSITION if target.has_position else Task.VELOCITY,
            position=target.position if target.has_position else zero,
            velocity=target.velocity if target.has_velocity else zero,
            acceleration=target.acceleration if accelerates else zero,
            yaw=None if target.mask & 0x400 or not math.isfinite(target.yaw) else target.yaw,
        )

    def pilot_mode(self, name: str) -> None:
        """The pilot turns the mode switch: it wins, and ends a failsafe, where the mode is available."""
        if name not in _NAMES:
            raise ValueError(f"unknown mode {name}: {', '.join(_NAMES)}")
        if not self._available(_NAMES[name]):
            return
        self.failsafe, self._lost_at = False, None
        self._enter(_NAMES[name])

    def _enter(self, mode: int) -> None:
        self._goes_back = False
        super()._enter(mode)

    def _heard(self, *, needs_position: bool) -> None:
        if self.around is not None:
            self._heard_at, self._needs_position = self.around.now, needs_position

    def _stream_available(self) -> bool:
        """Whether a setpoint is newer than COM_OF_LOSS_T: a single one is enough (PX4 1.17, `offboardCheck`)."""
        around = self.around
        if around is None or around.now - self._heard_at > self.parameters["COM_OF_LOSS_T"]:
            return False
        return around.estimate.position_valid or not self._needs_position

    def _arming_refused(self, forced: bool) -> tuple[int, str] | None:
        around = self.around
        assert around is not None
        if self.parameters["NAV_DLL_ACT"] > 0 and around.ground_station_age > self.parameters["COM_DL_LOSS_T"]:
            return TEMPORARILY_REJECTED, "Preflight Fail: No connection to the GCS"
        if self.mode == OFFBOARD and not self._stream_available():
            return TEMPORARILY_REJECTED, "Arming denied: no offboard signal"
        if not around.estimate.position_valid:
            return TEMPORARILY_REJECTED, ""
        return None

    def _decide(self, around: Surroundings) -> Demand:
        if self.armed:
            self._watch_links(around)
        if self.mode == OFFBOARD:
            return self._offboard()
        if self.mode == LAND or (self.mode == RETURN and not around.estimate.on_earth):
            return Demand(Task.LAND)
        if self.mode == RETURN:
            return self.return_home(around)
        if self.mode == TAKE_OFF and not self.landed:
            hold = self.hold_here(around)
            if float(hold.position[2] - around.estimate.position[2]) < self.parameters["NAV_MC_ALT_RAD"]:
                self._enter(LOITER)
                self._hold = hold
        if self.landed and self.mode != TAKE_OFF:
            if self.armed and around.now - self._armed_at > self.parameters["COM_DISARM_PRFLT"]:
                self._disarm()
            return Demand(Task.IDLE)
        return self.hold_here(around)

    def _begin_return(self, around: Surroundings) -> Return:
        """As PX4's `RTL::computeReturnAltitude` has it, which with a cone may be lower than it flies now."""
        values, place = self.parameters, around.estimate.position
        distance, height = self.home.distance(place), float(place[2] - self.home.position[2])
        most, angle, near = values["RTL_RETURN_ALT"], values["RTL_CONE_ANG"], distance <= values["RTL_MIN_DIST"]
        if angle <= 0.0:
            height = max(height, most)
        else:
            if distance <= values["NAV_ACC_RAD"]:
                wanted = 2.0 * distance
            else:
                cone = distance / math.tan(math.radians(min(max(angle, 1.0), 89.0)))
                wanted = max(min(cone, most) if near else most, 2.0 * values["NAV_ACC_RAD"])
            height = height if wanted < height else min(wanted, most)
        fixed = values["MPC_YAW_MODE"] == _YAW_FIXED
        yaw = self.home.yaw if near else None if fixed else self.home.bearing(place)
        floor = float(self.home.position[2])
        return Return(self.home, around.estimate, around.now, floor + height, values["RTL_LAND_DELAY"], yaw)

    def _offboard(self) -> Demand:
        target, around = self._target, self.around
        assert around is not None
        if self.landed and target.task is Task.POSITION:
            if target.position[2] < around.estimate.position[2] + 0.03:
                if self.armed and around.now - self._armed_at > self.parameters["COM_DISARM_PRFLT"]:
                    self._disarm()
                return Demand(Task.IDLE)
            self.landed = False
        elif self.landed and target.task is Task.ATTITUDE and target.thrust > self.parameters["MPC_THR_HOVER"]:
            self.landed = False
        return target

    def _watch_links(self, around: Surroundings) -> None:
        if self.mode == OFFBOARD and not self._stream_available():
            self._lost_at = around.now if self._lost_at is None else self._lost_at
            if around.now - self._lost_at > _FAILSAFE_DELAY:
                lands = not around.estimate.position_valid
                action = LAND if lands else _LOSS_ACTIONS.get(int(self.parameters["COM_OBL_RC_ACT"]), RETURN)
                self._fail("Failsafe activated: no offboard signal", action)
                self._goes_back = True
        else:
            self._lost_at = None
        if self._goes_back and self._stream_available():
            self.failsafe = False
            self._enter(OFFBOARD)
        station_lost = around.ground_station_age > self.parameters["COM_DL_LOSS_T"]
        if self.parameters["NAV_DLL_ACT"] > 0 and station_lost and self.mode not in (LAND, RETURN):
            self._fail("Failsafe activated: no ground station", LAND if self.parameters["NAV_DLL_ACT"] == 3 else RETURN)
        if not around.estimate.position_valid and self.mode in (POSITION, LOITER, RETURN, TAKE_OFF):
            self._fail("Failsafe activated: position lost", LAND)

    def _fail(self, text: str, mode: int) -> None:
        self.failsafe, self._lost_at = True, None
        self.say(mavlink.MAV_SEVERITY_CRITICAL, text)
        self._enter(mode)

    def _feels_ground(self, around: Surroundings) -> bool:
        """PX4 looks for a vertical speed of nothing; without poses only the barometer tells it one."""
        return around.estimate.position_valid or self.parameters["EKF2_BARO_CTRL"] != 0

    def _disarm(self) -> None:
        super()._disarm()
        self.failsafe = False


def _along_heading(target: PositionTarget, yaw: float) -> PositionTarget:
    """A target of BODY_NED in the world: it has no position, and no acceleration here."""
    x, y, z = target.velocity.tolist()
    velocity = np.array([math.cos(yaw) * x - math.sin(yaw) * y, math.sin(yaw) * x + math.cos(yaw) * y, z])
    return replace(target, mask=target.mask | 0x1C7, velocity=velocity)
