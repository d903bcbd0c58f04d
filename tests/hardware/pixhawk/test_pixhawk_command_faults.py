"""Faults of who commands, injected on real sockets; the table in docs/hardware/pixhawk.md names these tests."""

from __future__ import annotations

import socket
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pixhawk_rig import HOVER, QUICK, Rig, fresh, landed, wait_until
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from virtual_time import CLOCK, Aside

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import Authority, EventKind, OutcomeStatus
from doorman.hardware.pixhawk.wire.codec import signing_time
from doorman.rig.emulators.autopilot.dialects import PX4


def test_pilot_changes_the_mode(hovering, flavour):
    rig = hovering(flavour)
    assert rig.pilot.setpoint(HOVER)
    rig.emulator.pilot_mode("position")
    assert ("position" if flavour == "px4" else "loiter") in rig.happens(EventKind.CONTROL_LOST).message
    assert not rig.pilot.setpoint(HOVER)
    assert rig.pilot.hold().status is OutcomeStatus.CONTROL_LOST
    assert rig.pilot.land().status is OutcomeStatus.CONTROL_LOST
    counts = rig.emulator.receiver.received
    name = "SET_ATTITUDE_TARGET"
    quiet, beats = counts[name], counts["HEARTBEAT"]
    assert wait_until(lambda: counts["HEARTBEAT"] > beats)
    assert counts[name] <= quiet + 1 and rig.emulator.brain.armed, "nothing is commanded, and nothing falls down"
    assert rig.pilot.engage().done, "only a new request takes it back"


def test_pilot_kills_the_motors(rigs):
    rig = rigs("px4").fly()
    rig.emulator.kill_switch()
    assert "kill switch" in rig.happens(EventKind.CONTROL_LOST).message
    assert rig.emulator.brain.armed and not rig.pilot.setpoint(HOVER)
    rig.emulator.kill_switch(stop=False)
    rig.happens(EventKind.AUTOPILOT_FAILSAFE, begins=False)
    assert not rig.pilot.setpoint(HOVER), "it may lie on the floor"


def test_pilot_disarms(rigs):
    rig = rigs("px4").fly()
    rig.emulator.pilot_disarms()
    assert "disarmed" in rig.happens(EventKind.CONTROL_LOST).message
    assert not rig.pilot.setpoint(HOVER)


def test_a_pilot_who_disarms_is_not_overruled_where_acknowledgements_get_lost(rigs):
    rig = rigs("px4").open()
    assert rig.pilot.engage().done
    rig.emulator.receiver.mute_commands = 1000
    assert rig.pilot.arm().done, "the heartbeat says so"
    received = rig.emulator.receiver.commands[mavlink.MAV_CMD_COMPONENT_ARM_DISARM]
    rig.emulator.pilot_disarms()
    assert rig.pilot.arm(1.0).status in (OutcomeStatus.NOT_READY, OutcomeStatus.DONE)
    rig.happens(EventKind.CONTROL_LOST)
    CLOCK.sleep(1.5)
    assert not rig.emulator.brain.armed
    assert rig.emulator.receiver.commands[mavlink.MAV_CMD_COMPONENT_ARM_DISARM] <= received + 1


def test_a_pilot_who_takes_over_is_not_overruled_where_acknowledgements_get_lost(rigs):
    rig = rigs("px4").open()
    rig.emulator.receiver.mute_commands = 1000
    outcome = Aside(rig.pilot.engage)
    assert wait_until(lambda: rig.pilot.status().authority is Authority.ENGAGED)
    rig.emulator.pilot_mode("position")
    assert outcome.result(20.0).status in (OutcomeStatus.DONE, OutcomeStatus.CONTROL_LOST)
    CLOCK.sleep(1.5)
    assert rig.emulator.brain.is_in("position")


@pytest.mark.parametrize("before", [1.2, 0.05])
def test_a_vehicle_that_somebody_arms_while_we_make_ready_is_left_to_him(rigs, before):
    """Well before the mode is asked for; or so late that a heartbeat shows it only with the mode."""
    rig = rigs("px4", {"timeouts": replace(QUICK, stream_before_mode=1.5)}).open()
    mode = rig.emulator.brain.mode
    outcome = Aside(lambda: rig.pilot.engage(unarmed=True))
    CLOCK.sleep(1.5 - before)
    with rig.emulator.lock:
        rig.emulator.brain.request_arming(arm=True, forced=True)
    told = outcome.result(20.0)
    assert told.status is OutcomeStatus.CONTROL_LOST and "somebody has armed" in told.message
    assert rig.pilot.status().authority is Authority.NONE
    assert before < 1.0 or rig.emulator.brain.mode == mode


def test_autopilot_loses_its_estimate(rigs):
    rig = rigs("px4").fly()
    rig.emulator.estimator.failed = True
    rig.happens(EventKind.CONTROL_LOST)
    rig.happens(EventKind.AUTOPILOT_FAILSAFE)
    rig.happens(EventKind.STATE_STALE)  # positions still come
    rig.happens(EventKind.STATUS_TEXT, words="ailsafe")
    assert landed(rig)


def test_arming_refused(rigs):
    rig = rigs("px4", {"timeouts": replace(QUICK, arming=0.5)}).open()
    assert rig.pilot.engage().done
    rig.emulator.brain.refusal = "PreArm: hatch open"
    outcome = rig.pilot.arm()
    assert outcome.status is OutcomeStatus.REFUSED and "hatch open" in outcome.message
    rig.emulator.brain.refusal = ""
    outcome = rig.pilot.arm(0.2)
    assert outcome.status is OutcomeStatus.REFUSED and not rig.pilot.state().armed
    rig.happens(EventKind.COMMAND_REFUSED)
    rig.emulator.brain.refusal = None
    assert rig.pilot.arm().done


def test_mode_refused(rigs):
    rig = rigs("ardupilot", {"timeouts": replace(QUICK, mode=0.5, stream_before_mode=0.2)}).open()
    rig.emulator.estimator.failed = True
    assert wait_until(lambda: not rig.emulator.estimator.estimate.position_valid)
    outcome = rig.pilot.engage()
    assert not outcome.done
    assert rig.pilot.status().authority is Authority.NONE
    counts = rig.emulator.receiver.received
    before, beats = counts["SET_POSITION_TARGET_LOCAL_NED"], counts["HEARTBEAT"]
    assert wait_until(lambda: counts["HEARTBEAT"] > beats)
    assert counts["SET_POSITION_TARGET_LOCAL_NED"] <= before + 1, "the stream has ended"


def test_commands_lost_and_unanswered(rigs):
    rig = rigs("px4").open()
    rig.emulator.receiver.ignore_commands = 2
    assert rig.pilot.engage().done
    rig.emulator.receiver.mute_commands = 2
    assert rig.pilot.arm().done
    rig.emulator.receiver.ignore_commands = 1000
    assert rig.pilot.disarm().status is OutcomeStatus.TIMED_OUT
    rig.happens(EventKind.COMMAND_UNANSWERED)


def test_autopilot_reboots(rigs):
    rig = rigs("px4").fly()
    rig.emulator.reboot(silence=0.3)
    rig.happens(EventKind.REBOOTED)
    rig.happens(EventKind.CONTROL_LOST)
    assert not rig.pilot.setpoint(HOVER)
    assert fresh(rig), "rates are asked for again"
    assert not rig.pilot.state().armed


def test_clock_jumps(hovering, flavour):
    """By more than the autopilot's own time-outs, which do not count by it."""
    rig = hovering(flavour)
    rig.emulator.clock.jumped += 20.0
    rig.happens(EventKind.CLOCK_JUMPED)
    assert fresh(rig)
    status = rig.pilot.status()
    assert status.clock_offset == pytest.approx(CLOCK.now() - rig.emulator.clock.now, abs=0.5)
    assert status.authority is Authority.ENGAGED
    assert EventKind.REBOOTED not in {event.kind for event in rig.seen}


def test_foreign_systems_talk(rigs):
    rig = rigs("px4").open()
    stranger, station = (7, 1), (254, 190)
    for sender, kind, vendor in ((stranger, 13, 12), (station, 6, 8)):
        rig.emulator.send(mavlink.MAVLink_heartbeat_message(kind, vendor, 0x81, 6 << 16, 4, 3), sender)
        rig.emulator.send(mavlink.MAVLink_local_position_ned_message(2**31, 9, 9, 9, 0, 0, 0), sender)
        rig.emulator.send(mavlink.MAVLink_command_ack_message(400, 0), sender)
    rig.happens(EventKind.FOREIGN)
    assert wait_until(lambda: rig.pilot.status().foreign >= 6)
    sample = rig.pilot.state()
    assert np.linalg.norm(sample.position) < 0.1 and not sample.armed and sample.mode.name == "auto: loiter"
    assert not rig.pilot.status().namesake
    rig.emulator.send(mavlink.MAVLink_heartbeat_message(6, 8, 0x81, 6 << 16, 4, 3), (255, 190))
    assert wait_until(lambda: rig.pilot.status().namesake)


POSITION = PX4.modes["position"]


@pytest.fixture
def key(tmp_path: Path) -> Path:
    path = tmp_path / "key"
    path.write_bytes(bytes(range(32)))
    path.chmod(0o600)
    return path


IMPATIENT = {"timeouts": replace(QUICK, heartbeat=0.2)}


class Impostor:
    """Another socket that speaks with ids of its choice."""

    def __init__(self, rig: Rig, ids: tuple[int, int] = (1, 1), key: bytes | None = None) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)
        self.address = self.socket.getsockname()
        self._rig, self._line = rig, mavlink.MAVLink(None, *ids)
        if key is not None:
            signing = self._line.signing
            signing.secret_key, signing.sign_outgoing, signing.link_id, signing.timestamp = key, True, 7, signing_time()

    def __enter__(self) -> Impostor:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def say(self, message: Any) -> None:
        self.socket.sendto(message.pack(self._line), ("127.0.0.1", self._rig.port))

    def heartbeat(self) -> None:
        """One of a disarmed PX4 that waits, and a position far away."""
        self.say(mavlink.MAVLink_heartbeat_message(13, 12, 0x01, POSITION, 3, 3))
        self.say(mavlink.MAVLink_local_position_ned_message(2**31, 9, 9, 9, 0, 0, 0))

    def answered(self) -> bool:
        """Whether anything has been sent to it."""
        try:
            return bool(self.socket.recv(65536))
        except BlockingIOError:
            return False


def test_another_address_is_taken_on_the_ground_after_silence(rigs):
    rig = rigs("px4", IMPATIENT).open()
    with Impostor(rig) as other:
        other.heartbeat()
        event = rig.happens(EventKind.PEER_CHANGED)
        assert event.values["address"] == other.address and not event.values["taken"]
        assert np.linalg.norm(rig.pilot.state().position) < 0.1 and not other.answered()
        rig.forget()
        rig.emulator.outgoing.cut = True
        assert wait_until(lambda: other.heartbeat() or other.answered())
        rig.happens(EventKind.PEER_CHANGED)
        assert any(event.values.get("taken") for event in rig.seen)


def test_another_address_is_refused_while_armed(rigs):
    rig = rigs("px4", IMPATIENT).open()
    assert rig.pilot.engage().done and rig.pilot.arm().done
    with Impostor(rig) as other:
        other.say(mavlink.MAVLink_command_ack_message(400, 0))  # whatever it is: not only heartbeats
        assert "refused while armed" in rig.happens(EventKind.PEER_CHANGED).message
        rig.emulator.outgoing.cut = True
        rig.happens(EventKind.LINK_LOST)
        for _ in range(30):
            other.heartbeat()
            CLOCK.sleep(0.01)
        assert rig.pilot.state().armed and EventKind.LINK_LOST in rig.pilot.status().conditions
        assert not other.answered()
        rig.emulator.outgoing.cut = False
        rig.happens(EventKind.LINK_LOST, begins=False)
        assert not any(event.values.get("taken") for event in rig.seen)


def test_another_address_with_a_signature_is_taken(rigs, key):
    rig = rigs("px4", {**IMPATIENT, "signing_key": key}, signing_key=bytes(range(32))).open()
    assert rig.pilot.engage().done and rig.pilot.arm().done
    rig.emulator.outgoing.cut = True
    with Impostor(rig) as unsigned, Impostor(rig, key=bytes(range(32))) as signed:
        assert wait_until(lambda: unsigned.heartbeat() or signed.heartbeat() or signed.answered())
        assert not unsigned.answered()
        assert rig.happens(EventKind.PEER_CHANGED).values["address"] == signed.address


def test_another_autopilot_from_the_same_address_is_refused(rigs):
    rig = rigs("px4").open()
    for system, component in ((7, 1), (1, 2)):
        rig.forget()
        rig.emulator.send(mavlink.MAVLink_heartbeat_message(13, 12, 0x81, POSITION, 4, 3), (system, component))
        event = rig.happens(EventKind.PEER_CHANGED)
        assert (event.values["system"], event.values["component"]) == (system, component)
    assert not rig.pilot.state().armed and rig.pilot._link.target == (1, 1)


def test_a_vehicle_whose_thrust_px4_does_not_take(rigs):
    """PX4's `fill_thrust` knows neither dodecarotors nor decarotors."""
    outcome = rigs("px4", vehicle_type=29).open().pilot.engage()
    assert outcome.status is OutcomeStatus.NOT_READY and "position setpoints" in outcome.message
    assert rigs("px4", {"setpoints": "position"}, vehicle_type=29).open().pilot.engage().done
    assert rigs("ardupilot", vehicle_type=29).open().pilot.engage().done


def test_other_vehicle_first(rigs):
    """Told which system to fly, it waits for that one."""
    rig = rigs("px4", {"vehicle_system": 3, "timeouts": replace(QUICK, open=0.3)})
    rig.emulator.open()
    with pytest.raises(BackendError, match="none from a multirotor"):
        rig.pilot.open()
    plane = rigs("px4", {"timeouts": replace(QUICK, open=0.3)}, vehicle_type=1)
    plane.emulator.open()
    with pytest.raises(BackendError, match="multirotor"):
        plane.pilot.open()


def test_signature_missing(rigs, key):
    rig = rigs("px4", {"signing_key": key, "timeouts": replace(QUICK, open=0.3)})
    rig.emulator.open()
    with pytest.raises(BackendError, match="signatures.*PX4 before 1.17"):
        rig.pilot.open()
    rig.happens(EventKind.BAD_SIGNATURE)
    signed = rigs("px4", {"signing_key": key}, signing_key=bytes(range(32))).open()
    assert signed.pilot.engage().done and signed.pilot.arm().done
    signed.emulator.send(mavlink.MAVLink_heartbeat_message(13, 12, 0x81, POSITION, 4, 3), (1, 1))
    signed.happens(EventKind.BAD_SIGNATURE)
    assert signed.pilot.status().authority is Authority.ENGAGED
