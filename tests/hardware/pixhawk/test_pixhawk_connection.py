"""Connection strings and settings: what they mean, and what is refused before anything is opened."""

from __future__ import annotations

import pytest

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import Autopilot, PixhawkConfig, Rates, Timeouts
from doorman.hardware.pixhawk.wire.connection import DEFAULT_BAUD, Endpoint, Transport, parse_connection


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("udp:14540", Endpoint(Transport.UDP_LISTEN, "127.0.0.1", 14540)),
        ("udp::14540", Endpoint(Transport.UDP_LISTEN, "127.0.0.1", 14540)),
        ("udp://:14540", Endpoint(Transport.UDP_LISTEN, "127.0.0.1", 14540)),
        ("udp:127.0.0.1:14550", Endpoint(Transport.UDP_LISTEN, "127.0.0.1", 14550)),
        ("udpin:0.0.0.0:14550", Endpoint(Transport.UDP_LISTEN, "0.0.0.0", 14550)),
        ("udpout:192.168.1.7:14550", Endpoint(Transport.UDP_SEND, "192.168.1.7", 14550)),
        ("udpout:pixhawk.lan:14550:14555", Endpoint(Transport.UDP_SEND, "pixhawk.lan", 14550, own_port=14555)),
        ("tcp:localhost:5760", Endpoint(Transport.TCP, "localhost", 5760)),
        ("tcp://127.0.0.1:5760", Endpoint(Transport.TCP, "127.0.0.1", 5760)),
        ("/dev/ttyACM0", Endpoint(Transport.SERIAL, device="/dev/ttyACM0", baud=DEFAULT_BAUD)),
        ("/dev/ttyACM0:57600", Endpoint(Transport.SERIAL, device="/dev/ttyACM0", baud=57600)),
        ("serial:/dev/ttyUSB0:921600", Endpoint(Transport.SERIAL, device="/dev/ttyUSB0", baud=921600)),
        ("serial:///dev/ttyUSB0:921600", Endpoint(Transport.SERIAL, device="/dev/ttyUSB0", baud=921600)),
        ("COM3:57600", Endpoint(Transport.SERIAL, device="COM3", baud=57600)),
    ],
)
def test_connection_strings(text, expected):
    assert parse_connection(text) == expected


@pytest.mark.parametrize(
    "text", ["udpin:127.0.0.1:14540", "udpout:10.0.0.1:14550:14555", "tcp:localhost:5760", "serial:/dev/ttyACM0:57600"]
)
def test_an_endpoint_reads_like_a_connection_string(text):
    assert str(parse_connection(text)) == text


@pytest.mark.parametrize(
    "text",
    ["", "udp", "udp:", "udp:x", "udp:0", "udp:70000", "udp:a b:1", "tcp::5760", "udpout:5760", "udpout:10.0.0.1:1:0",
     "tcp:10.0.0.1:1:2", "http://x:1",
     "serial:", "/dev/ttyACM0:100", "udp:١٢٣", "tcp:host:-1"],
)  # fmt: skip
def test_malformed_connection_strings_are_refused_with_what_is_allowed(text):
    with pytest.raises(BackendError, match="udpout:HOST:PORT") as caught:
        parse_connection(text)
    assert caught.value.field == "pixhawk.connection"


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: PixhawkConfig("udp:14540", setpoints="velocity"), "setpoints"),
        (lambda: PixhawkConfig("udp:14540", on_mocap_loss="pray"), "on_mocap_loss"),
        (lambda: PixhawkConfig("udp:14540", on_stop="fall"), "on_stop"),
        (lambda: PixhawkConfig("udp:14540", vehicle_system=0), "vehicle_system"),
        (lambda: PixhawkConfig("udp:14540", system_id=256), "system_id"),
        (lambda: Timeouts(link=0.0), "timeouts.link"),
        (lambda: Timeouts(open=float("nan")), "timeouts.open"),
        (lambda: Rates(attitude=-1.0), "rates.attitude"),
        (lambda: PixhawkConfig("udp:14540", rates=Rates(setpoint=5.0)), "rates.setpoint"),
        (lambda: PixhawkConfig("udp:14540", hover_force=0.0), "hover_force"),
        (lambda: PixhawkConfig("nowhere"), "connection"),
    ],
)
def test_settings_that_cannot_work_are_refused(make, field):
    with pytest.raises(BackendError) as caught:
        make()
    assert caught.value.field == f"pixhawk.{field}"


def test_the_constructor_touches_no_device():
    pilot = Autopilot(PixhawkConfig("serial:/dev/no/such/port:57600"))
    pilot.stop()
    with pytest.raises(BackendError, match="cannot be opened"):
        pilot.open()
