"""What surrounds every mission: the way up, the supervisor's watch, and a defined way down whatever happens."""

from __future__ import annotations

import contextlib
import math
import signal
from collections.abc import Callable, Mapping

from doorman.clocks import LOOK
from doorman.control.estimation.pose_age import oldest_pose
from doorman.copying import Uncopied
from doorman.exceptions import BackendError, RecordingError
from doorman.flight.ends import BY_REST, RECENT, CarriedWatch, End, FallWatch, RestWatch, tells_of_crash
from doorman.flight.ground.before_arming import engage, try_gripper
from doorman.flight.ground.judgements import Verdict, judge_age
from doorman.flight.hover import STEEPEST, PoseDelay, measure_hover
from doorman.flight.journal import Journal
from doorman.flight.way_back import WayBack, fly_to, out_of_the_doorway
from doorman.hardware.dynamixel import ServoFault
from doorman.hardware.pixhawk import Authority, EventKind, LandedState, Outcome, PositionSetpoint, SampleStatus
from doorman.hardware.pixhawk.sequences import GROUND_PATIENCE, LEAST_HEIGHT, MOST_HEIGHT
from doorman.hardware.safety import Action, Fault, Observation, Observer, Supervisor
from doorman.hardware.vehicle import Places, VehicleBackend, VehicleLinks
from doorman.model import Model
from doorman.recording import Recorder

SAME_INTERRUPT = 0.1
"""Two Ctrl-C within this are one, as what a process group and a parent both send [s]."""


STOPPING = (signal.SIGTSTP, signal.SIGTTIN, signal.SIGTTOU)
"""Signals that would stop the program in flight, as Ctrl-Z and a terminal that another program uses do."""


class GuardedFlight(Uncopied):
    """One way up and down again, on links that are open.

    Args:
        model: Model of the scenario.
        links: Of the vehicle.
        recorder: Gets what links and supervisor tell.
        say: Called with every step, one line.
    """

    def __init__(
        self, model: Model, links: VehicleLinks, recorder: Recorder, say: Callable[[str], None] = lambda words: None
    ) -> None:
        self.model, self.links, self._listener, self._recorder = model, links, say, recorder
        self.places = Places.of(model)
        self.backend = VehicleBackend(model, links)
        self._observer = Observer(model, self.backend, oldest_pose(model.scenario.control))
        self._fall, self._rest, self._carried = FallWatch(), RestWatch(model, links.clock.now), CarriedWatch()
        self._poses = PoseDelay()
        self.measured: dict[str, float] = {}
        """What was measured in hover, by name: hover thrust, slope and shape of the thrust, delay and latency of the poses."""
        self.supervisor = Supervisor(
            links, self._look, model.scenario.safety, refuge=lambda position: out_of_the_doorway(model, position)[-1]
        )
        self.journal = Journal(links, self.supervisor, recorder)
        self.way_back = WayBack(model, links, self.supervisor, self.say, self._note)
        self._armed_once = self._told_to_arm = False

    def say(self, words: str) -> None:
        """Tell the listener of a step; a listener that fails, as a terminal that is gone, does not concern the flight.

        Args:
            words: One line.
        """
        with contextlib.suppress(Exception, SystemExit):
            self._listener(words)

    def begin(self) -> None:
        """Let the supervisor watch from now on."""
        self._armed_once = self._told_to_arm = False
        self.links.release()
        servos = self.links.servos
        if servos.read().fault & ServoFault.JUMPED and not self.links.autopilot.state().armed:
            servos.recover(servos.config.boot_timeout)  # on the ground a person may have turned the arm
        self.supervisor.open()

    def rise(self) -> str:
        """Engage, arm, take off, fly to the hover point; returns what went wrong, or nothing."""
        autopilot, places = self.links.autopilot, self.places
        self.supervisor.rising = True
        if autopilot.state().armed:  # since the checklist
            return "arm: somebody has armed the vehicle"
        if reason := try_gripper(self.links, self.say):
            return f"gripper: {reason}"
        height = float(places.hover[2] - autopilot.state().position[2])
        if not LEAST_HEIGHT <= height <= MOST_HEIGHT:
            return f"take off: the hover point is {height:.2f} m up; allowed: {LEAST_HEIGHT:g} to {MOST_HEIGHT:g} m"
        steps: tuple[tuple[str, Callable[[], Outcome]], ...] = (
            ("engage", lambda: engage(self.links, lambda: self.supervisor.action is not None)),
            ("arm", autopilot.arm),
            ("take off", lambda: autopilot.take_off(height)),
        )
        for name, step in steps:
            if self.supervisor.action is not None:
                return f"{name}: not begun: {self.supervisor.reason}"
            self._note()  # not in the air, where no watch waits for the disk yet
            self.say(name)
            self._told_to_arm |= name == "arm"
            outcome = step()
            self._armed_once = self._armed_once or autopilot.state().armed
            if not outcome.done:
                return f"{name}: {outcome}"
        self.say("fly to the hover point")
        if not fly_to(self.links, places.hover, places.yaw, go_on=lambda: self.supervisor.action is None):
            return self.supervisor.reason or "the hover point was not reached"
        if reason := self._measure_hover():
            return reason
        self.supervisor.hand_over()
        return ""

    def _measure_hover(self) -> str:
        """Calibrate newtons in hover, where they are sent. Returns what went wrong."""
        config = self.links.config.pixhawk
        if config.setpoints != "attitude" or config.hover_force is None:
            return ""
        at = PositionSetpoint(self.places.hover, self.places.yaw)
        reason = measure_hover(
            self.links.autopilot, at, self.say, lambda figures: self._write_measured("hover", figures),
            steepest=math.inf if self.model.contact.tied > 0.0 else STEEPEST,
        )  # fmt: skip
        if self.supervisor.action is not None or reason:
            return f"measure the thrust in hover: {self.supervisor.reason or reason}"
        if reason := self._take_delay():
            return f"measure the delay of the poses: {reason}"
        return "" if self.links.engaged else "measure the thrust in hover: doorman no longer controls the vehicle"

    def _write_measured(self, topic: str, figures: Mapping[str, float]) -> None:
        self._recorder.write(topic, 0.0, figures)
        self.measured.update({f"{topic}_{name}": float(value) for name, value in figures.items()})

    def _take_delay(self) -> str:
        """Correct the poses' stamps by what the bob has shown of their delay. Returns why it is too long to be flown."""
        mocap, delay = self.links.mocap, self._poses.delay
        if mocap is None or math.isnan(delay):
            return ""
        figures = mocap.statistics
        latency, limit = figures.latency + delay, oldest_pose(self.model.scenario.control)
        self.say(f"poses arrive {1e3 * latency:.0f} ms late, {1e3 * delay:+.0f} ms from mocap.latency")
        quickest = mocap.config.latency + delay
        self._write_measured("poses", {"delay": delay, "latency": quickest, "rate": figures.frame_rate})
        self.backend.pose_delay = delay
        row = judge_age(latency, figures.frame_rate, limit)
        return f"{row.found}: {row.advice}" if row.verdict is Verdict.BAD else ""

    def descend(self) -> End:
        """Whatever happened: the vehicle ends on the ground, or with the pilot; nothing watches it any more then.

        An interrupt on the way, as by Ctrl-C, lands it where it is, and is raised again then.

        Returns:
            Where it ended.
        """
        try:
            end = self._come_down()
        except BaseException as error:  # whatever it is: it lands, and has the cameras' poses until it has
            end = self._land_here(error)
            if not isinstance(error, Exception):
                raise
        finally:
            self.supervisor.stop()
            self._note()
        return end

    def _land_here(self, error: BaseException) -> End:
        """Have the supervisor land it, and wait; nothing can be done about it by further interrupts."""
        while True:
            with contextlib.suppress(KeyboardInterrupt, SystemExit):
                mistake = isinstance(error, Exception)
                self.supervisor.report(Fault.SESSION if mistake else Fault.OPERATOR_LAND)
                self.say(f"land: {type(error).__name__}: {error}" if mistake else "land")
                return self._await_motors()

    def _note(self) -> None:
        """Write the events so far; a mistake in that ends no landing."""
        try:
            self.journal.take(self.backend.epoch)
        except RecordingError as error:
            self.say(str(error))
        except Exception as error:
            self.say(f"not recorded: {type(error).__name__}: {error}")

    def _come_down(self) -> End:
        """Whatever happened: the vehicle ends on the ground, or with the pilot."""
        autopilot = self.links.autopilot
        if self.supervisor.rising and self.way_back.may_go_on() and autopilot.state().landed is LandedState.ON_GROUND:
            self.say("the vehicle has not taken off: disarm")
            if not autopilot.disarm().done:
                autopilot.land()
        elif self.way_back.may_go_on():
            if self.way_back.ends_here:
                self.say("behind the door")
            else:
                self.say("back to the hover point")
                self.way_back.fly()
            self.way_back.await_operator()
            if self.way_back.may_go_on():
                self.say("land")
                if autopilot.state().status is SampleStatus.FRESH:
                    autopilot.land()
                else:  # nothing would report when it has
                    autopilot.request_landing()
        return self._await_motors()

    def _await_motors(self) -> End:
        """Wait until they stop, or as long as makes sense."""
        autopilot = self.links.autopilot
        self.say("wait for the motors to stop")
        begin = ended = self.links.clock.now()
        patience = self.links.config.pixhawk.timeouts.landing  # until then it gets the cameras' poses
        stands_since: float | None = None
        while (end := self._end()) is not End.NOT_FLOWN:
            self._note()
            self.links.let_go()  # for the pilot, too: a vehicle that holds on to the door cannot be flown away
            waits = end in (End.STILL_ARMED, End.TAKEN_OVER)
            waits = waits or (end is End.UNHEARD and self.supervisor.action is not Action.RELEASE)
            now = self.links.clock.now()
            ended = now if waits else ended
            landed = autopilot.state().landed is LandedState.ON_GROUND
            stands = landed and end is End.STILL_ARMED and autopilot.status().authority is Authority.LANDING
            stands_since = (stands_since or now) if stands else None
            if stands_since is not None and now - stands_since > GROUND_PATIENCE:
                autopilot.disarm()
                stands_since = None
            if now - begin > patience or now - ended > RECENT:  # a vehicle that falls is on the ground then
                break
            self.links.clock.sleep(LOOK)
        return self._borne_out(end)

    def _borne_out(self, end: End) -> End:
        """The word for the end that cameras, tilt and the autopilot's texts bear out."""
        if end is End.UNHEARD:  # it may still fly
            return BY_REST.get(self._rest.judged, end) if self._rest.still else end
        if end is not End.LANDED:
            return end
        if self._fall.fell:
            return End.FALLEN
        if tells_of_crash(self.journal.lines):
            return End.CRASHED
        return BY_REST.get(self._rest.judged, end)

    @property
    def seen(self) -> str:
        """What cameras and tilt show of a vehicle that does not stand where it should, and of what it lay on in the air."""
        return "; ".join(filter(None, (self._carried.words, self._rest.words)))

    def _look(self) -> Observation:
        seen = self._observer.look()
        heard = seen.conditions.isdisjoint({EventKind.STATE_STALE, EventKind.LINK_LOST, EventKind.DEVICE_LOST})
        runs = seen.armed and not self.links.autopilot.state().terminated
        self._fall.note(seen.now, seen.speed, runs, heard)
        lands = seen.authority in (Authority.LANDING, Authority.LOST) or not heard
        lands = lands or self.supervisor.action in (Action.LAND, Action.RELEASE)
        self._rest.note(seen, runs, lands)
        self._carried.note(seen, self.links.holding)
        if self.supervisor.rising and self.links.mocap is not None:
            with contextlib.suppress(BackendError):  # closed
                self._poses.note(self.links.mocap.read(), self.links.autopilot.state())
        return seen

    def _end(self) -> End:
        """How the flight has ended, or `STILL_ARMED` while it has not."""
        autopilot = self.links.autopilot
        state, status = autopilot.state(), autopilot.status()
        if EventKind.LINK_LOST in status.conditions and (state.armed or self._told_to_arm):
            return End.UNHEARD
        if not state.armed:
            return End.LANDED if self._armed_once else End.NOT_FLOWN
        return End.TAKEN_OVER if status.authority is Authority.LOST else End.STILL_ARMED
