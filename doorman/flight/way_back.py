"""The way back after a mission: out of the doorway and to the hover point, with what links and autopilot still tell."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

import numpy as np

from doorman.arrays import Array
from doorman.clocks import LOOK
from doorman.control.passage import behind_the_door
from doorman.control.way_out import way_out
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import Authority
from doorman.hardware.pixhawk.setpoints import AT_REST, SPEED, StraightWay
from doorman.hardware.safety import Action, Fault, Supervisor
from doorman.hardware.vehicle import Places, VehicleLinks
from doorman.hardware.vehicle.links import DRIFTS_FOR, Whereabouts
from doorman.hardware.vehicle.waiting import TOGETHER
from doorman.model import Model

_NEAR = 0.06
"""Distance that counts as arrived [m]."""


def fly_to(
    links: VehicleLinks,
    place: Array,
    yaw: float,
    timeout: float = 20.0,
    go_on: Callable[[], bool] = lambda: True,
    begin: Array | None = None,
    speed: float = SPEED,
) -> bool:
    """Stream position setpoints along a `StraightWay` until the vehicle has arrived."""
    autopilot, where = links.autopilot, links.whereabouts()
    here = where.position if where.known or begin is None else begin
    way = StraightWay(links.clock.now(), here, place, where.yaw, yaw, speed)
    end = known = way.since + way.duration
    while (now := links.clock.now()) < end + timeout:
        if not go_on() or not autopilot.setpoint(way.setpoint(now)):
            return False
        if autopilot.status().authority is not Authority.ENGAGED:
            return False
        where = links.whereabouts()
        near = np.linalg.norm(where.position - place) < _NEAR and np.linalg.norm(where.velocity) < AT_REST
        known = max(known, now) if where.known else known
        if now >= end and (near if where.known else now - known > DRIFTS_FOR):
            return True
        links.clock.sleep(LOOK)
    return False


_PLANS = 5
"""Plans of a way out, each from where the vehicle is then."""
_RELEASE_TIME = 0.6
"""For the gripper to open before the vehicle backs off [s]."""
OPERATOR_PATIENCE = 30.0
"""For a person: in the hover after the mission was given up, or to open a gripper that does not open by itself [s]."""
_ON_THE_WAY = 3.0
"""For places on the way back, which need not be reached exactly [s]."""
LOST_SPEED = 3 * SPEED / 2
"""On the way back by dead reckoning, whose error grows with the time, and which PX4 gives up 5 s after the last pose [m/s]."""
_BLIND = {Fault.POSE, Fault.POSE_JUMPED, Fault.DIVERGENCE, Fault.INCONSISTENT}
"""After these the cameras do not say where the vehicle is, or the autopilot does not."""


def out_of_the_doorway(model: Model, position: Array) -> list[Array]:
    """Places of O_B, one after the other, square to the frame, shape (3,) each, world frame [m]."""
    return way_out(model, position, model.start_angle)


class WayBack:
    """Flies a vehicle back as far as it is ours, once for a flight."""

    def __init__(
        self,
        model: Model,
        links: VehicleLinks,
        supervisor: Supervisor,
        say: Callable[[str], None],
        note: Callable[[], None],
    ) -> None:
        self._model, self._links, self._supervisor = model, links, supervisor
        self._say, self._note = say, note
        self._places = Places.of(model)
        self._last: Whereabouts | None = None

    def may_go_on(self) -> bool:
        """Whether the vehicle is ours, armed, and not commanded to land. The caller flies it, and is alive."""
        autopilot = self._links.autopilot
        ours = autopilot.status().authority is Authority.ENGAGED and autopilot.state().armed
        if ours:
            self._supervisor.acknowledge()
        if not ours or self._supervisor.action in (Action.LAND, Action.RELEASE):
            return False
        autopilot.resume()  # the supervisor may have latched a hold while no program flew
        return True

    @property
    def ends_here(self) -> bool:
        """Whether the vehicle has flown through the doorway, to land behind it."""
        seen = self._links.whereabouts()
        return seen.known and behind_the_door(self._model, seen.position)

    def fly(self) -> None:
        """Let go of the door, fly out of the doorway and to the hover point without turning, and turn there."""
        places = self._places
        self._links.hold()
        if not self._let_go() or not self._heard():
            return
        yaw = self._links.whereabouts().yaw
        for _ in range(_PLANS):
            if self._fly_out(yaw):
                break
            self._say("the autopilot's position jumped: plan the way out again")
        if self.may_go_on() and not self._lost and self._travel(places.hover, yaw):
            self._travel(places.hover, places.yaw)

    def await_operator(self) -> None:
        """Hover as long as the operator, who gave the mission up, may want to see or take the vehicle, if nothing is wrong."""
        if not self._only_given_up or not self.may_go_on():
            return
        self._say(
            f"hover: press Ctrl-C again to land, or take over by radio; the vehicle lands after {OPERATOR_PATIENCE:g} s"
        )
        self._links.hold()
        begin = self._links.clock.now()
        while self.may_go_on() and self._only_given_up:
            if self._links.clock.now() - begin > OPERATOR_PATIENCE:
                break
            self._note()
            self._links.clock.sleep(LOOK)

    @property
    def _only_given_up(self) -> bool:
        """Whether the operator has given the mission up, and no fault was found."""
        return {finding.fault for finding in self._supervisor.findings} == {Fault.OPERATOR_ABORT}

    def _let_go(self) -> bool:
        """Hover until the gripper is open; returns whether it is, and the vehicle still ours."""
        begin = held = self._links.clock.now()
        tried = False
        while (now := self._links.clock.now()) - begin < OPERATOR_PATIENCE and self.may_go_on():
            self._links.let_go()
            if self._jumps():
                self._links.hold()
            if not self._links.holding:
                if now - held >= _RELEASE_TIME:
                    return True
            else:
                held = now
                if now - begin > 2.0 * _RELEASE_TIME and not tried:
                    tried = True
                    self._say(
                        f"the gripper does not open: hover for {OPERATOR_PATIENCE:g} s; open it by hand, or take over by radio"
                    )
                    with contextlib.suppress(BackendError):  # a servo that has shut down lets go when it restarts
                        self._links.servos.recover(self._links.servos.config.boot_timeout)
            self._note()
            self._links.clock.sleep(LOOK)
        return self.may_go_on() and not self._links.surely_holding

    def _fly_out(self, yaw: float) -> bool:
        """Fly out of the doorway from here; returns False where the way is to be planned anew, since the position jumped."""
        begin = self._links.whereabouts().position
        jumped = False

        def go_on() -> bool:
            nonlocal jumped
            jumped = jumped or self._jumps()
            return not jumped

        for place in out_of_the_doorway(self._model, begin):
            patience = DRIFTS_FOR if self._lost else _ON_THE_WAY
            if not self._travel(place, yaw, patience, begin, go_on) and (jumped or not self.may_go_on()):
                return not jumped
            begin = place
        return True

    def _jumps(self) -> bool:
        """Whether where the vehicle is said to be has jumped since the last look, as when an estimate is put right."""
        before, self._last = self._last, self._links.whereabouts()
        if before is None or not (before.known and self._last.known):
            return False
        most = TOGETHER + self._model.scenario.safety.speed * max(self._last.time - before.time, 0.0)
        return float(np.linalg.norm(self._last.position - before.position)) > most

    def _travel(
        self,
        place: Array,
        yaw: float,
        timeout: float = 20.0,
        begin: Array | None = None,
        go_on: Callable[[], bool] = lambda: True,
    ) -> bool:
        """Fly to a place, also while the position is unknown; returns whether it arrived, as far as that is known."""

        def still() -> bool:
            self._note()
            return self.may_go_on() and go_on()

        return fly_to(self._links, place, yaw, timeout, still, begin, LOST_SPEED if self._lost else SPEED)

    def _heard(self) -> bool:
        """Hover until it is known where the vehicle is, or has not been for long; whether the vehicle is still ours."""
        begin = self._links.clock.now()
        while self.may_go_on() and not self._seen:
            if self._links.clock.now() - begin > DRIFTS_FOR:
                self._say("the autopilot's state is too old: fly back by the autopilot's position control")
                break
            self._links.clock.sleep(LOOK)
        return self.may_go_on()

    @property
    def _lost(self) -> bool:
        """Whether the way back is flown by dead reckoning, the autopilot's or ours."""
        found = {finding.fault for finding in self._supervisor.findings}
        return not self._seen or not found.isdisjoint(_BLIND)

    @property
    def _seen(self) -> bool:
        return self._links.whereabouts().known
