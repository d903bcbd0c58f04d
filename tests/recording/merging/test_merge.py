"""Logs of autopilots on a run's clock: the offset is found, and nothing of either is lost."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from command_line import run as doorman
from made_logs import ULog, tumbling, write_dataflash, write_run, write_ulog

from doorman.exceptions import RecordingError
from doorman.recording import Recording
from doorman.recording.merging import align, read_log
from doorman.recording.merging.alignment import align_by_rates

RATES = tumbling(7)
DURATION = 20.0
WRITERS = {"px4": (write_ulog, "log.ulg"), "ardupilot": (write_dataflash, "log.bin")}


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Folder of a run."""
    folder = tmp_path_factory.mktemp("flown")
    write_run(folder / "recording.mcap", RATES, DURATION)
    return folder


@pytest.fixture(scope="module")
def recording(flown):
    return Recording.load(flown)


@pytest.mark.parametrize("autopilot", WRITERS)
@pytest.mark.parametrize("offset", [-2.0, -0.7133, 0.0, 1.2345, 2.0, -412.4])
def test_the_offset_is_found_to_milliseconds(autopilot, offset, recording, tmp_path):
    write, name = WRITERS[autopilot]
    write(tmp_path / name, RATES, -3.0 - offset if offset < -3.0 else 0.0, DURATION + 3.0 - offset, offset)
    found = align(recording, read_log(tmp_path / name))
    assert found.offset == pytest.approx(offset, abs=0.005)
    assert 0.0 <= found.deviation < 0.005
    assert abs(found.offset - offset) < 5.0 * found.deviation + 1e-3
    assert "rates" in found.by


def test_a_log_of_ten_rates_a_second_and_one_of_a_part_of_the_flight(recording, tmp_path):
    for rate, start, end in ((10.0, 0.0, 20.0), (50.0, 6.0, 14.0)):
        write_ulog(tmp_path / "log.ulg", RATES, start, end, 0.5, rate)
        assert align(recording, read_log(tmp_path / "log.ulg")).offset == pytest.approx(0.5, abs=0.005)


def test_the_controllers_rates_serve_where_no_gyroscope_is_logged(recording, tmp_path):
    write_dataflash(tmp_path / "log.bin", RATES, 0.0, DURATION, 0.25, gyro=False)
    assert align(recording, read_log(tmp_path / "log.bin")).offset == pytest.approx(0.25, abs=0.005)


def test_a_log_of_another_flight_is_refused(recording, tmp_path):
    write_ulog(tmp_path / "log.ulg", tumbling(8), 0.0, DURATION, 0.0)
    with pytest.raises(RecordingError, match="do not agree"):
        align(recording, read_log(tmp_path / "log.ulg"))


def test_rates_that_repeat_are_refused():
    time = np.arange(0.0, 20.0, 0.01)
    swing = np.stack([np.sin(2.0 * np.pi * time), 0.0 * time, 0.0 * time], axis=1)
    with pytest.raises(RecordingError, match="several places"):
        align_by_rates(time, swing, time[:1200], swing[:1200])


@pytest.mark.parametrize(
    ("length", "size", "words"), [(0, 1.0, "too short"), (100, 1.0, "too short"), (1000, 0.0, "does not turn")]
)
def test_rates_that_tell_nothing_are_refused(length, size, words):
    time = np.arange(0.0, 20.0, 0.01)
    with pytest.raises(RecordingError, match=words):
        align_by_rates(time, RATES(time), time[:length], size * RATES(time[:length]))


def test_noise_as_large_as_the_motion_is_borne():
    draw = np.random.default_rng(5)
    time, fast = np.arange(0.0, 30.0, 0.005), np.arange(0.0, 30.0, 0.001)
    run, log = RATES(time), RATES(fast - 1.1)
    noisy = [values + np.std(values) * draw.normal(size=values.shape) for values in (run, log)]
    assert align_by_rates(time, noisy[0], fast, noisy[1]).offset == pytest.approx(-1.1, abs=0.005)


def test_rates_that_are_not_finite_are_left_out():
    time = np.arange(0.0, 20.0, 0.01)
    seen = RATES(time + 0.3)
    seen[::37] = math.nan
    assert align_by_rates(time, RATES(time), time, seen).offset == pytest.approx(0.3, abs=0.005)


@pytest.mark.parametrize("shift", [0.01, 0.02, 0.04])
def test_the_deviation_is_that_of_the_mean_of_the_parts(shift):
    """Six parts that are off by ±δ in turn: their mean has the deviation δ √(6/5) / √6 = δ / √5."""
    time = np.arange(0.0, 60.0, 0.01)
    seen = RATES(time + shift * np.where((time // 10.0) % 2, 1.0, -1.0))
    found = align_by_rates(np.arange(-5.0, 65.0, 0.01), RATES(np.arange(-5.0, 65.0, 0.01)), time, seen)
    assert found.offset == pytest.approx(0.0, abs=1.5 * shift)
    spread = math.hypot(shift, found.offset)  # each part's distance from the whole, squared and averaged
    assert found.deviation == pytest.approx(spread / math.sqrt(5.0), rel=0.1)


def test_timesync_of_the_run_goes_before_everything_else(tmp_path):
    told = {"epoch": {"epoch": 5000.0}, "clock": {"autopilot_offset": 4300.25, "round_trip": 0.004}}
    write_run(tmp_path / "recording.mcap", RATES, 1.0, told)
    write_dataflash(tmp_path / "log.bin", RATES, 700.0, 703.0, 0.0)
    found = align(Recording.load(tmp_path), read_log(tmp_path / "log.bin"))
    assert (found.offset, found.deviation) == (pytest.approx(-699.75), pytest.approx(0.002))
    assert "in the run" in found.by


def test_timesync_of_the_log_serves_where_the_run_has_none(tmp_path):
    write_run(tmp_path / "recording.mcap", RATES, 1.0, {"epoch": {"epoch": 5000.0}})
    log = ULog()  # the autopilot's clock is 4300.25 s behind the companion's
    offsets = [-4_300_250_000 + step for step in (-300, 0, 300)]
    rows = [(700.0 + i, value) for i, value in enumerate([0, *offsets])]
    log.topic("timesync_status", "int64_t estimated_offset;", "q", rows)
    log.write(tmp_path / "log.ulg")
    found = align(Recording.load(tmp_path), read_log(tmp_path / "log.ulg"))
    assert found.offset == pytest.approx(-699.75)
    assert "in the log" in found.by


# ---------------------------------------------------------------- the command


def test_merge_of_a_px4_log(flown, recording, tmp_path):
    write_ulog(tmp_path / "log.ulg", RATES, 0.0, DURATION, -1.5)
    done = doorman("merge", str(flown), str(tmp_path / "log.ulg"), "--json")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    merged = Recording.load(told["file"])
    assert merged.complete
    assert told["file"] == str(flown / "merged" / "recording.mcap")
    assert merged.header["merged"]["offset"] == told["offset"] == pytest.approx(-1.5, abs=0.005)
    for field, values in recording["measurement"].items():
        np.testing.assert_array_equal(merged["measurement"][field], values)
    topic = merged["px4/vehicle_angular_velocity_0"]
    assert topic.time[0] >= 0.0 and topic["xyz"].shape == (told["topics"]["px4/vehicle_angular_velocity_0"], 3)
    assert topic["sample"][0] == 2**63 - 1
    aligned = RATES(topic.time) * (1.0, -1.0, -1.0)
    assert np.std(topic["xyz"] - aligned) < 0.015
    assert merged["px4/battery_status_0"]["voltage_v"][0] == pytest.approx(15.2, abs=1e-6)
    assert merged["px4/logged_messages"]["message"][0] == "INFO: landed"
    again = doorman("merge", str(flown), str(tmp_path / "log.ulg"))  # the folder is still that of one run
    assert again.exit_code == 0 and "± " in again.output and "cross-correlation" in again.output


def test_merge_of_an_ardupilot_log(flown, tmp_path):
    write_dataflash(tmp_path / "log.bin", RATES, 0.0, DURATION, 0.75)
    out = tmp_path / "both.mcap"
    done = doorman("merge", str(flown / "recording.mcap"), str(tmp_path / "log.bin"), "--out", str(out))
    assert done.exit_code == 0, done.output
    merged = Recording.load(out)
    assert {"ardupilot/IMU_0", "ardupilot/IMU_1", "ardupilot/RATE", "ardupilot/MSG", "ardupilot/BAT"} <= set(merged)
    assert merged["ardupilot/MSG"]["Message"][0] == "landed"
    assert merged["ardupilot/BAT"]["Volt"][0] == pytest.approx(15.2)
    assert merged["ardupilot/IMU_0"].time[0] == pytest.approx(0.75, abs=0.005)


def test_an_offset_may_be_given(flown, tmp_path):
    write_ulog(tmp_path / "log.ulg", tumbling(8), 10.0, 12.0, 0.0)
    out = tmp_path / "both.mcap"
    done = doorman("merge", str(flown), str(tmp_path / "log.ulg"), "--offset", "-10", "--out", str(out))
    assert done.exit_code == 0, done.output
    assert Recording.load(out)["px4/battery_status_0"].time[0] == pytest.approx(0.0)


HEADS = (b"ULog\x01\x12\x35\x01", b"\xa3\x95\x80")


@pytest.mark.parametrize("content", [b"", b"hello", *HEADS, HEADS[0] + b"\xff" * 400, b"\xa3\x95" * 300])
def test_files_that_are_no_logs_are_refused_in_a_line(content, flown, tmp_path):
    (tmp_path / "log.bin").write_bytes(content)
    done = doorman("merge", str(flown), str(tmp_path / "log.bin"))
    assert done.exit_code == 2
    assert "not expected" not in done.output


def test_what_cannot_be_merged_is_refused(flown, tmp_path):
    write_ulog(tmp_path / "log.ulg", RATES, 0.0, 3.0, 0.0)
    own = str(flown / "recording.mcap")
    for arguments in (("--offset", "-100"), ("--offset", "nan"), ("--offset", "0", "--out", own)):
        done = doorman("merge", str(flown), str(tmp_path / "log.ulg"), *arguments)
        assert done.exit_code == 2, done.output
    assert doorman("merge", str(flown), str(tmp_path / "none.ulg")).exit_code == 2
    assert Recording.load(own).complete
