"""Parameter check over real sockets: what it finds, that it only reads, and that it writes on request alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from pixhawk_rig import SAFE, WEIGHT, wait_until
from virtual_time import CLOCK

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import Autopilot, PixhawkConfig, ThrustCurve
from doorman.hardware.pixhawk.dialect import ARDUPILOT, PX4
from doorman.hardware.pixhawk.parameters.protocol import read_parameters
from doorman.hardware.pixhawk.parameters.rules import Severity, rules_for
from doorman.rig.emulators.autopilot.dialects import ARDUPILOT_MOCAP, PX4_DEFAULTS, PX4_MOCAP, ParameterStore

MOCAP = {"px4": PX4_MOCAP, "ardupilot": ARDUPILOT_MOCAP}
COMPENSATED = ThrustCurve(0.4, WEIGHT, hover_voltage=15.6)


def test_defaults_of_the_autopilots_are_found_wanting(rigs, flavour):
    rig = rigs(flavour, {"mocap": True}).open()
    wrong = {"COM_OF_LOSS_T": 5.0, "COM_OBL_RC_ACT": 0} if flavour == "px4" else {"GUID_OPTIONS": 0, "FS_GCS_ENABLE": 0}
    for name, value in wrong.items():
        rig.emulator.parameters[name] = value
    findings = {finding.name: finding for finding in rig.pilot.check_parameters()}
    assert findings.keys() >= wrong.keys() | MOCAP[flavour].keys()
    for name, finding in findings.items():
        assert finding.given is not None
        assert str(finding).startswith(name) and finding.wanted in str(finding) and finding.why in str(finding)
    assert rig.emulator.parameters.writes == 0


@pytest.mark.parametrize(
    ("flavour", "chosen", "wrong"),
    [("px4", {"COM_OBL_RC_ACT": 3}, {"RTL_RETURN_ALT", "RTL_CONE_ANG", "RTL_MIN_DIST", "NAV_ACC_RAD", "MPC_YAW_MODE"}),
     ("ardupilot", {"FS_GCS_ENABLE": 1}, {"RTL_ALT", "RTL_LOIT_TIME", "WPNAV_JERK", "FS_GCS_TIMEOUT", "FS_OPTIONS"})],
)  # fmt: skip
def test_a_return_must_not_climb(rigs, flavour, chosen, wrong):
    """Where the vehicle is to land on its pad without us; where it lands in place nobody asks."""
    rig = rigs(flavour, {"write_parameters": True})
    for name, value in chosen.items():
        rig.emulator.parameters[name] = value
    rig.open()
    assert {finding.name for finding in rig.pilot.check_parameters()} == wrong
    assert set(rig.pilot.fix_parameters()) == wrong
    assert rig.pilot.check_parameters() == ()


def test_parameters_are_written_only_on_request_and_then_read_back(rigs, flavour):
    rig = rigs(flavour, {"mocap": True}).open()
    with pytest.raises(BackendError, match="only on request"):
        rig.pilot.fix_parameters()
    assert rig.emulator.parameters.writes == 0
    rig.pilot.stop()
    rig.pilot = Autopilot(replace(rig.config, write_parameters=True), CLOCK)
    rig.pilot.open()
    written = rig.pilot.fix_parameters()
    assert set(MOCAP[flavour]) <= set(written)
    assert rig.emulator.parameters.writes == len(written)
    for name, value in MOCAP[flavour].items():
        assert rig.emulator.parameters[name] == pytest.approx(value)
    assert rig.pilot.check_parameters() == ()


def test_other_bits_of_an_option_stay_as_they_are(rigs):
    rig = rigs("ardupilot", {"write_parameters": True})
    rig.emulator.parameters["GUID_OPTIONS"] = 0b10001
    assert rig.open().pilot.fix_parameters() == ("GUID_OPTIONS",)
    assert rig.emulator.parameters["GUID_OPTIONS"] == 0b11001


def test_a_parameter_that_does_not_answer_is_said_so(rigs):
    rig = rigs("px4").open()
    del rig.emulator.parameters["COM_OBL_RC_ACT"]
    (finding,) = rig.pilot.check_parameters()
    assert finding.name == "COM_OBL_RC_ACT" and finding.given is None and "did not answer" in str(finding)


def test_px4_before_1_14_is_told_from_newer(rigs):
    rig = rigs("px4", {"write_parameters": True})
    rig.emulator.parameters = ParameterStore({**PX4_DEFAULTS, "COM_OBL_ACT": (0, 6)}, bytewise=True)
    for name, value in SAFE["px4"].items():
        rig.emulator.parameters[name] = value
    (finding,) = (one for one in rig.open().pilot.check_parameters() if one.name == "COM_OBL_ACT")
    assert finding.severity is Severity.ERROR and finding.name == "COM_OBL_ACT"
    assert "must be absent" in str(finding) and "1.14" in finding.why and "COM_RCL_EXCEPT" in finding.why
    assert rig.pilot.fix_parameters() == ()


def test_a_quality_that_poses_do_not_have_must_not_be_asked_for(rigs):
    rig = rigs("ardupilot", {"mocap": True}, vision=True)
    rig.emulator.parameters["VISO_QUAL_MIN"] = 30
    (finding,) = rig.open().pilot.check_parameters()
    assert finding.name == "VISO_QUAL_MIN" and finding.severity is Severity.ERROR
    received, estimator = rig.emulator.receiver.received, rig.emulator.estimator

    def poses(enough: Callable[[], bool]) -> bool:
        return wait_until(lambda: rig.pilot.mocap(CLOCK.now(), np.zeros(3), [1.0, 0.0, 0.0, 0.0]) and enough())

    assert poses(lambda: received["VISION_POSITION_ESTIMATE"] > 5) and estimator.accepted_poses == 0
    rig.emulator.parameters["VISO_QUAL_MIN"] = 0
    assert poses(lambda: estimator.accepted_poses > 0)


def test_many_are_read_through_a_bad_link(rigs):
    rig = rigs("px4").open()
    rig.emulator.outgoing.loss = rig.emulator.incoming.loss = 0.15
    names = rig.emulator.parameters.names
    values = read_parameters(rig.pilot._link, names)
    assert len(values) >= len(names) - 1
    assert all(value == pytest.approx(rig.emulator.parameters[name]) for name, value in values.items())


def test_names_that_cannot_travel_are_refused(rigs):
    rig = rigs("px4").open()
    for name in ("", "X" * 17, "ÄÖÜ"):
        with pytest.raises(BackendError, match="not a parameter"):
            read_parameters(rig.pilot._link, [name])


def config(**settings) -> PixhawkConfig:
    return PixhawkConfig(**{"connection": "udp:14540", **settings})


def names(dialect, **settings) -> set[str]:
    delay = settings.pop("delay", None)
    return {rule.names[-1] for rule in rules_for(dialect, config(**settings), delay)}


def test_rules_depend_on_the_set_up():
    assert "EKF2_EV_CTRL" not in names(PX4) and "EKF2_EV_CTRL" in names(PX4, mocap=True)
    assert "GUID_OPTIONS" in names(ARDUPILOT) and "GUID_OPTIONS" not in names(ARDUPILOT, setpoints="position")
    assert "MC_BAT_SCALE_EN" not in names(PX4) and "MC_BAT_SCALE_EN" in names(PX4, thrust_curve=COMPENSATED)
    assert "MOT_BAT_VOLT_MAX" in names(ARDUPILOT, thrust_curve=COMPENSATED)
    assert "FS_GCS_ENABLE" in names(ARDUPILOT, ground_station=False), "it heeds our id, whatever we call ourselves"
    assert "VISO_DELAY_MS" not in names(ARDUPILOT, mocap=True)


def test_the_measured_delay_of_the_poses_is_compared_where_stamps_do_not_carry_it():
    (rule,) = (r for r in rules_for(ARDUPILOT, config(mocap=True), 0.05) if r.names == ("VISO_DELAY_MS",))
    assert rule.accepts(45.0) and not rule.accepts(10.0)
    (rule,) = (r for r in rules_for(PX4, config(mocap=True), 0.05) if r.names == ("EKF2_EV_DELAY",))
    assert rule.accepts(0.0) and not rule.accepts(50.0)


def test_the_ground_station_rule_follows_our_id():
    (rule,) = (r for r in rules_for(ARDUPILOT, config(system_id=245)) if "SYSID_MYGCS" in r.names)
    assert rule.accepts(245.0) and not rule.accepts(255.0)


@pytest.mark.parametrize("dialect", [PX4, ARDUPILOT], ids=lambda dialect: dialect.name)
def test_every_rule_accepts_what_it_would_write(dialect):
    rules = rules_for(dialect, config(mocap=True, thrust_curve=COMPENSATED), 0.02)
    assert len({rule.names for rule in rules}) == len(rules)
    for rule in rules:
        for given in (0.0, 3.0, 77.0, -1.0):
            assert rule.value is None or rule.accepts(rule.value(given)), rule.names
        assert rule.why and rule.wanted and all(len(name) <= 16 for name in rule.names)
        assert rule.severity in Severity


def test_nothing_is_written_in_the_air(rigs, flavour):
    rig = rigs(flavour, {"write_parameters": True})
    rig.fly()
    with pytest.raises(BackendError, match="ground"):
        rig.pilot.fix_parameters()


@pytest.mark.parametrize(("dialect", "name"), [(PX4, "THR_MDL_FAC"), (ARDUPILOT, "MOT_THST_EXPO")])
@pytest.mark.parametrize(
    ("shape", "good", "bad"), [(0.0, (0.2, 0.65, 1.0), (0.0, 0.1)), (1.0, (0.0, 0.2), (0.3, 1.0)), (0.4, (0.0, 0.8), (0.9,))]
)  # fmt: skip
def test_motors_are_linearised_once(dialect, name, shape, good, bad):
    """By the autopilot or by the curve here: by neither is thrust twice as steep as it is taken for, by both half as steep."""
    curve = ThrustCurve(0.4, WEIGHT, shape=shape)
    (rule,) = (r for r in rules_for(dialect, config(thrust_curve=curve)) if r.names == (name,))
    assert [value for value in (*good, *bad) if rule.accepts(value)] == list(good)
    assert rule.value is None, "the rate loops were tuned with it: a person decides"
    assert name not in names(dialect, setpoints="position", thrust_curve=curve)


@pytest.mark.parametrize(
    ("limit", "action"), [("BATT_LOW_VOLT", "BATT_FS_LOW_ACT"), ("BATT_CRT_VOLT", "BATT_FS_CRT_ACT")]
)
@pytest.mark.parametrize(
    ("lands", "volts", "given_up", "warned"),
    [
        (1, 14.0, None, True),
        (1, 14.0, 13.9, True),
        (1, 14.0, 14.8, False),
        (1, 0.0, None, False),
        (0, 14.0, None, False),
    ],
)
def test_ardupilots_own_voltage_limit_acts_after_the_mission_is_given_up(limit, action, lands, volts, given_up, warned):
    """Else it would land in the doorway."""
    (rule,) = (r for r in rules_for(ARDUPILOT, config(min_voltage=given_up)) if r.names == (limit,))
    assert (rule.counts({action: lands}) and not rule.accepts(volts)) is warned
