"""The supervisor on links to an emulated vehicle: whom it asks, what it takes away, and what it does when nobody follows.

All of it is in this process and in virtual time: unlike the flights of this folder, it needs no idle machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from linked_rig import LinkedRig, until
from virtual_time import CLOCK

from doorman.control.estimation.pose_age import oldest_pose
from doorman.exceptions import BackendError
from doorman.hardware.interface import Command
from doorman.hardware.pixhawk import Authority
from doorman.hardware.safety import Action, Assessor, Fault, Observation, Observer, Supervisor
from doorman.hardware.safety import supervisor as supervisor_module
from doorman.hardware.vehicle import VehicleBackend


@pytest.fixture(scope="module")
def linked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LinkedRig]:
    with LinkedRig(tmp_path_factory.mktemp("rig")) as made:
        yield made


@pytest.fixture
def rig(linked: LinkedRig) -> LinkedRig:
    """The rig, well and on its pad, before every test."""
    linked.heal()
    return linked


@pytest.fixture
def hovering(rig: LinkedRig) -> Iterator[LinkedRig]:
    """In the air, under our command."""
    autopilot = rig.links.autopilot
    for outcome in (autopilot.engage(), autopilot.arm(), autopilot.take_off(0.4)):
        assert outcome.done, outcome
    yield rig
    autopilot.resume()
    autopilot.land()


def watching(rig: LinkedRig) -> Supervisor:
    """A supervisor to whom all looks well, whatever is: only what it is told counts."""
    return Supervisor(rig.links, lambda: Observation(now=CLOCK.now(), commanding=False))


def jumps(*by: float) -> Callable[[LinkedRig], None]:
    return lambda rig: setattr(rig.cameras, "jump", by)


def come_late(seconds: float) -> Callable[[LinkedRig], None]:
    return lambda rig: setattr(rig.cameras, "delay", seconds)


def turns(servo: int, degrees: float) -> Callable[[LinkedRig], None]:
    return lambda rig: rig.set_zero(servo, round(degrees / 360.0 * 4096))


@pytest.mark.parametrize(
    ("lie", "fault", "within"),
    [
        (jumps(0.03, 0.0, 0.0), Fault.POSE_JUMPED, 0.25),
        (come_late(0.06), Fault.POSE_LATE, 0.35),
        (turns(2, 5.0), Fault.SERVOS_JUMPED, 0.1),
    ],
    ids=["jump", "late", "servo"],
)
def test_what_lies_is_found_first(hovering, lie, fault, within):
    """By the true cause, and not by what follows from it."""
    model, links = hovering.model, hovering.links
    observer = Observer(model, VehicleBackend(model, links), oldest_pose(model.scenario.control))
    assessor, found = Assessor(model.scenario.safety), []

    def look(duration: float) -> None:
        end = CLOCK.now() + duration
        while CLOCK.now() < end:
            found.extend(assessor.assess(replace(observer.look(), commanding=True, command_age=0.0)))
            CLOCK.sleep(0.02)

    look(1.0)
    assert not found
    began = CLOCK.now()
    lie(hovering)
    look(1.0)
    assert found[0].fault is fault
    assert found[0].action is Action.RETREAT
    assert found[0].time - began <= within


def test_abort_without_a_mission_is_a_retreat(hovering):
    supervisor = watching(hovering)
    supervisor.report(Fault.OPERATOR_ABORT)
    assert supervisor.action is Action.RETREAT
    assert hovering.links.inhibited == Fault.OPERATOR_ABORT.value


def test_a_supervisor_that_sees_nothing_gives_no_sign_of_life(rig):
    def blind() -> Observation:
        raise BackendError("closed")

    with Supervisor(rig.links, blind):
        until(lambda: rig.links.inhibited is not None, "nobody may fly a mission")
        assert "silent" in rig.links.inhibited
    rig.links.release()


def test_a_supervisor_goes_on_watching_after_a_mistake_of_its_own(rig, capsys):
    looks: list[float] = []

    def mistaken() -> Observation:
        looks.append(CLOCK.now())
        if len(looks) < 5:
            raise ValueError("made up")
        return Observation(now=CLOCK.now(), commanding=False)

    with Supervisor(rig.links, mistaken) as supervisor:
        until(lambda: len(looks) > 10, "further looks")
        assert rig.links.inhibited is None
        supervisor.report(Fault.OPERATOR_LAND)
        assert supervisor.action is Action.LAND
    assert capsys.readouterr().err.count("ValueError: made up") == 1
    rig.links.release()


def test_a_milder_action_does_not_replace_a_graver_one(hovering):
    asked: list[str] = []
    supervisor = watching(hovering)
    supervisor.watch_mission(asked.append)
    supervisor.report(Fault.OPERATOR_LAND)
    supervisor.report(Fault.OPERATOR_ABORT)
    assert supervisor.action is Action.LAND
    assert asked == []
    assert supervisor.reason == Fault.OPERATOR_LAND.value
    until(lambda: hovering.links.autopilot.status().authority is Authority.LANDING, "landing")


def test_a_retreat_that_nobody_flies_ends_in_a_landing(hovering, monkeypatch):
    monkeypatch.setattr(supervisor_module, "ACKNOWLEDGE_WITHIN", 0.3)
    with watching(hovering) as supervisor:
        supervisor.report(Fault.OPERATOR_ABORT)
        until(lambda: supervisor.action is Action.LAND, "the supervisor lands by itself")
        until(lambda: not hovering.links.autopilot.state().armed, "landed")


def test_a_retreat_that_nobody_flies_is_flown_by_the_supervisor(hovering, monkeypatch):
    monkeypatch.setattr(supervisor_module, "ACKNOWLEDGE_WITHIN", 0.3)
    begin = hovering.snapshot.truth.position.copy()
    away = np.array([-0.5, 0.1, 0.0])
    watch = Supervisor(
        hovering.links,
        lambda: Observation(now=CLOCK.now(), commanding=False, authority=Authority.ENGAGED),
        refuge=lambda position: position + away,
    )
    with watch as supervisor:
        supervisor.report(Fault.OPERATOR_ABORT)
        until(lambda: supervisor.action is Action.LAND, "the supervisor has flown back, and lands")
        place = hovering.snapshot.truth.position
        assert place == pytest.approx(begin + away, abs=0.12)
        assert {finding.fault for finding in supervisor.findings} == {Fault.OPERATOR_ABORT, Fault.SESSION}
        until(lambda: not hovering.links.autopilot.state().armed, "landed")


def test_a_retreat_that_somebody_flies_does_not(hovering, monkeypatch):
    monkeypatch.setattr(supervisor_module, "ACKNOWLEDGE_WITHIN", 0.1)
    supervisor = watching(hovering)
    supervisor.report(Fault.OPERATOR_ABORT)
    supervisor.acknowledge()
    CLOCK.sleep(0.2)
    supervisor.look_once()
    assert supervisor.action is Action.RETREAT


def test_a_vehicle_that_nobody_flies_on_from_its_hover_point_is_flown_back(hovering, monkeypatch):
    monkeypatch.setattr(supervisor_module, "SILENT_WITHIN", 1.0)

    def look() -> Observation:
        return Observation(now=CLOCK.now(), armed=True, commanding=False, authority=Authority.ENGAGED)

    supervisor = Supervisor(hovering.links, look)
    supervisor.rising = True
    supervisor.look_once()
    CLOCK.sleep(1.1)
    supervisor.look_once()
    assert supervisor.action is None, "on its way up it is in somebody's hands"
    supervisor.hand_over()
    supervisor.look_once()
    assert supervisor.action is None
    CLOCK.sleep(1.1)
    supervisor.look_once()
    assert [one.fault for one in supervisor.findings] == [Fault.SESSION_SILENT]
    assert supervisor.action is Action.RETREAT


def test_whoever_flies_it_back_must_go_on_saying_so(hovering, monkeypatch):
    monkeypatch.setattr(supervisor_module, "SILENT_WITHIN", 0.2)
    supervisor = watching(hovering)
    for _ in range(4):
        supervisor.acknowledge()
        CLOCK.sleep(0.1)
        supervisor.look_once()
    assert supervisor.action is None
    CLOCK.sleep(0.3)
    supervisor.look_once()
    assert supervisor.action is Action.RETREAT
    assert [one.fault for one in supervisor.findings] == [Fault.SESSION_SILENT]


def test_a_signals_wish_is_heeded_at_the_next_look(hovering):
    supervisor = watching(hovering)
    with supervisor._lock:  # as whoever is interrupted by the signal may hold it
        supervisor.wish(Fault.TERMINATED)
    assert supervisor.action is None
    supervisor.look_once()
    assert supervisor.action is Action.RETREAT


def test_a_mission_that_does_not_end_loses_the_vehicle(hovering, monkeypatch):
    monkeypatch.setattr(supervisor_module, "ABORT_WITHIN", 0.1)
    supervisor = Supervisor(hovering.links, lambda: Observation(now=CLOCK.now(), commanding=True))
    supervisor.watch_mission(lambda reason: None)
    supervisor.report(Fault.OPERATOR_ABORT)
    supervisor.look_once()
    assert supervisor.action is Action.ABORT
    CLOCK.sleep(0.2)
    supervisor.look_once()
    assert supervisor.action is Action.RETREAT
    assert Fault.MISSION_STUCK in {finding.fault for finding in supervisor.findings}


def test_a_mission_that_lost_the_vehicle_can_neither_read_nor_command(hovering):
    backend = VehicleBackend(hovering.model, hovering.links)
    command = Command(hovering.model.hover_input[0], np.zeros(3), np.zeros(hovering.model.n_arm))
    with backend:
        measurement = backend.read()
        assert measurement.position[2] == pytest.approx(0.64, abs=0.2)
        backend.command(command)
        hovering.links.inhibit("made up")
        for act in (backend.read, lambda: backend.command(command)):
            with pytest.raises(BackendError, match="made up"):
                act()
    assert hovering.links.servos.read().goals == pytest.approx(np.zeros(hovering.links.config.n_arm))


def test_commands_that_are_not_finite_are_errors(hovering):
    backend = VehicleBackend(hovering.model, hovering.links)
    good = Command(hovering.model.hover_input[0], np.zeros(3), np.zeros(hovering.model.n_arm))
    with backend:
        backend.read()
        for bad in (
            replace(good, thrust=np.nan),
            replace(good, attitude=np.array([0.0, np.inf, 0.0])),
            replace(good, arm_rates=np.zeros(2)),
        ):
            with pytest.raises(BackendError):
                backend.command(bad)


def test_a_backend_that_is_not_open_says_so(rig):
    backend = VehicleBackend(rig.model, rig.links)
    with pytest.raises(BackendError, match="not open"):
        backend.read()
    backend.stop()
    with backend, pytest.raises(BackendError, match="open already"):
        backend.open()


def test_commands_to_a_vehicle_that_does_not_obey_are_errors(rig):
    backend = VehicleBackend(rig.model, rig.links)
    with backend:
        backend.read()
        with pytest.raises(BackendError, match="does not control the autopilot"):
            backend.command(Command(10.0, np.zeros(3), np.zeros(rig.model.n_arm)))
