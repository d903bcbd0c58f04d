"""Parameter files: loaded into an autopilot they leave the checklist nothing to find."""

from __future__ import annotations

import re

import pytest
from command_line import run as doorman

from doorman.hardware.pixhawk import PixhawkConfig
from doorman.hardware.pixhawk.parameters.file import DIALECTS
from doorman.hardware.pixhawk.parameters.rules import rules_for
from doorman.rig.emulators.autopilot.dialects import ARDUPILOT_DEFAULTS, PX4_DEFAULTS

DEFAULTS = {"px4": PX4_DEFAULTS, "ardupilot": ARDUPILOT_DEFAULTS}


def loaded(text: str) -> dict[str, float]:
    """As a ground station reads it, with a comment before every parameter."""
    values, commented = {}, False
    for line in text.splitlines():
        if line.startswith("#"):
            commented = True
            continue
        assert commented, line
        fields = line.split("\t")
        name, value = fields[2:4] if len(fields) == 5 else line.split(",")
        if len(fields) == 5:
            assert fields[:2] == ["1", "1"] and fields[4] in ("6", "9")
            assert fields[4] == "9" or re.fullmatch(r"-?\d+", value)
        assert name not in values and len(name) <= 16
        values[name], commented = float(value), False
    return values


def printed(*arguments: str) -> dict[str, float]:
    done = doorman("parameters", *arguments)
    assert done.exit_code == 0, done.output
    return loaded(done.stdout)


@pytest.mark.parametrize("autopilot", DIALECTS)
@pytest.mark.parametrize("on_loss", ["land", "return"])
@pytest.mark.parametrize("mocap", ["mocap", "no-mocap"])
def test_nothing_is_left_for_the_checklist(autopilot, on_loss, mocap):
    values = printed(autopilot, "--on-loss", on_loss, f"--{mocap}")
    config = PixhawkConfig("udp:14540", mocap=mocap == "mocap")
    for rule in rules_for(DIALECTS[autopilot], config):
        if rule.value is None:
            assert not set(rule.names) & set(values)
        elif rule.counts(values):
            assert rule.accepts(values[rule.names[0]]), rule
        else:
            assert rule.names[0] not in values
    assert ("EKF2_EV_CTRL" in values or "VISO_TYPE" in values) == (mocap == "mocap")


def test_types_are_those_of_px4():
    values = doorman("parameters", "px4", "--on-loss", "return").stdout
    kinds = {line.split("\t")[2]: int(line.split("\t")[4]) for line in values.splitlines() if "\t" in line}
    known = {name: kind for name, (_, kind) in PX4_DEFAULTS.items() if name in kinds}
    assert len(known) > 10
    assert {name: kinds[name] for name in known} == known


def test_bits_are_set_beside_those_of_the_factory():
    assert printed("ardupilot", "--on-loss", "return")["FS_OPTIONS"] == 16 + 8


def test_what_depends_on_the_vehicle_and_the_scenario(model):
    px4, ardupilot = printed("px4"), printed("ardupilot")
    share = model.vehicle.mass * 9.81 / model.vehicle.max_thrust
    assert px4["MPC_THR_HOVER"] == pytest.approx(share**0.5, abs=2e-3)
    assert ardupilot["MOT_THST_HOVER"] == pytest.approx(share, abs=2e-3)
    assert printed("px4", "paper", "--set", "safety.low_battery=0.4")["BAT_LOW_THR"] == pytest.approx(0.35)
    assert 0.5 < px4["MIS_TAKEOFF_ALT"] < 3.0


def test_the_delay_of_poses():
    assert printed("ardupilot", "--mocap-delay", "0.012")["VISO_DELAY_MS"] == 12.0
    assert "VISO_DELAY_MS" not in printed("ardupilot")
    for wrong in ("-1", "nan", "3"):
        assert doorman("parameters", "ardupilot", "--mocap-delay", wrong).exit_code == 2


@pytest.mark.parametrize(
    ("autopilot", "options", "expected"),
    [
        ("px4", (), {"MAV_1_CONFIG": 102, "SER_TEL2_BAUD": 921600, "MAV_1_FLOW_CTRL": 0, "MAV_1_RATE": 0, "MAV_1_MODE": 2}),
        ("px4", ("--telem", "1", "--flow-control"), {"MAV_0_CONFIG": 101, "SER_TEL1_BAUD": 921600, "MAV_0_FLOW_CTRL": 1}),
        ("px4", ("--telem", "3", "--baud", "460800"), {"MAV_1_CONFIG": 103, "SER_TEL3_BAUD": 460800}),
        ("ardupilot", (), {"SERIAL2_PROTOCOL": 2, "SERIAL2_BAUD": 921, "BRD_SER2_RTSCTS": 0}),
        ("ardupilot", ("--telem", "1", "--baud", "115200"), {"SERIAL1_PROTOCOL": 2, "SERIAL1_BAUD": 115}),
    ],
)  # fmt: skip
def test_the_port_that_this_computer_is_wired_to(autopilot, options, expected):
    values = printed(autopilot, *options)
    assert {name: values.get(name) for name in expected} == expected


def test_usb_needs_no_port_and_ports_that_are_none_are_refused():
    for autopilot in DIALECTS:
        assert not [
            name for name in printed(autopilot, "--telem", "0") if name.startswith(("MAV_1", "SER_", "SERIAL", "BRD_"))
        ]
    for wrong in (("ardupilot", "--telem", "3"), ("px4", "--baud", "9600"), ("px4", "--telem", "4")):
        assert doorman("parameters", *wrong).exit_code == 2
