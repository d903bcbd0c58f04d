"""Emulated servos and the rate of the port: at another one than their own they neither hear nor speak."""

from __future__ import annotations

import dynamixel_sdk as sdk
import pytest
from servo_client import Client, PatientPort, exchange

from doorman.clocks import REAL_TIME
from doorman.rig.emulators.servos.bus import BusFaults, LaggingJoints, ServoBusLogic
from doorman.rig.emulators.servos.packets import Instruction
from doorman.rig.emulators.servos.unit import READY, EmulatedServo, ServoSetup

TORQUE, LED, BAUD_RATE, WATCHDOG = 64, 65, 8, 98
RATES = {9600: 0, 57_600: 1, 115_200: 2, 1_000_000: 3, 2_000_000: 4, 3_000_000: 5, 4_000_000: 6}
PING = "FF FF FD 00 01 03 00 01 19 4E"


class QuickPort(PatientPort):
    """A port that is not patient where nobody is awaited."""

    def setPacketTimeout(self, packet_length: int) -> None:
        self.setPacketTimeoutMillis(30.0)


@pytest.fixture
def scan(make_emulator):
    """Rates at which servo 1 of an emulator answers to a ping."""

    def answers(emulator, rates):
        port, packets = QuickPort(emulator.port), sdk.PacketHandler(2.0)
        found = []
        for rate in rates:
            assert port.setBaudRate(rate)
            if packets.ping(port, 1)[1] == sdk.COMM_SUCCESS:
                found.append(rate)
        port.closePort()
        return found

    return answers


@pytest.mark.parametrize("rate", RATES)
def test_a_scan_finds_a_servo_at_its_own_rate_alone(make_emulator, scan, rate):
    emulator = make_emulator([ServoSetup(1, {"baud rate": RATES[rate]})])
    assert scan(emulator, [*RATES, 19_200, 460_800]) == [rate]


def test_servos_of_one_bus_may_differ(make_emulator):
    emulator = make_emulator([ServoSetup(1), ServoSetup(2, READY | {"baud rate": 1}), ServoSetup(3)])
    client = Client(emulator)
    found, _ = client.packets.broadcastPing(client.port)
    client.port.closePort()
    assert sorted(found) == [1, 3]


def test_what_comes_at_another_rate_is_neither_obeyed_nor_heard():
    servo = EmulatedServo(ServoSetup(1))
    bus = ServoBusLogic([servo], LaggingJoints([0.0]), BusFaults(), None)
    light = Instruction(1, 0x03, bytes((LED, 0, 1)), True)
    assert bus.respond(1.0, Instruction(1, 0x03, bytes((WATCHDOG, 0, 5)), True), 1_000_000) != []
    assert bus.respond(1.0, Instruction(1, 0x03, bytes((TORQUE, 0, 1)), True), 1_000_000) != []
    for now in (1.05, 1.09):
        assert bus.respond(now, light, 57_600) == bus.respond(now, light, 19_200) == []
    assert servo.memory.get("led") == 0
    bus.tick(1.11)
    assert servo.memory.get("bus watchdog") == 0xFF, "it feeds the watchdog"


def test_a_rate_that_is_written_holds_from_the_next_packet_on(connect, scan):
    emulator, client = connect()
    assert client.write(BAUD_RATE, 1, 2) == 0, "the answer still comes at the old one"
    assert client.packets.ping(client.port, 1)[1] == sdk.COMM_RX_TIMEOUT
    assert scan(emulator, RATES) == [115_200]


def test_a_rate_that_the_port_does_not_show_is_answered(make_emulator):
    serial = pytest.importorskip("serial")
    emulator = make_emulator([1], clock=REAL_TIME)
    with serial.Serial(emulator.port, 4_500_000, timeout=0.5) as port:
        port.write(bytes.fromhex(PING))
        assert len(port.read(14)) == 14


def test_who_sets_no_rate_is_heard_by_the_first_servo(make_emulator):
    emulator = make_emulator([ServoSetup(1, {"baud rate": 2})])
    assert len(exchange(emulator, PING)) == 14
    emulator.unplug()
    emulator.plug_in()
    assert len(exchange(emulator, PING)) == 14
