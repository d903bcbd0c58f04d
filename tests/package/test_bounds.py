"""Bounds of every reader: what is damaged, too large or no number is refused or left out, counted, and costs nothing else."""

from __future__ import annotations

import json
import math
import re
import struct
import subprocess
import sys
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import zstandard
from command_line import run as doorman
from hypothesis import given
from hypothesis import strategies as st
from made_logs import ULog, tumbling, write_dataflash, write_run, write_ulog
from mcap_records import CHUNK, MESSAGE, SCHEMA, edited, record, records
from pymavlink.DFReader import DFReader_binary
from pyulog import ULog as OtherULog
from urdf_variants import DOOR, VEHICLE

from doorman.bounds import parse_number, parse_numbers
from doorman.campaign.results import read_parts, write_part
from doorman.checks import number
from doorman.cli.values import parse_overrides
from doorman.exceptions import DimensionError, DoormanError, RecordingError, ScenarioError, UrdfError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.recording import Recorder, Recording
from doorman.recording.merging import align, read_log
from doorman.scenario import PlannerSection, Scenario

RATES = tumbling(11)
HUGE = 1 << 20_000
"""More digits than Python prints."""
MOST_MEMORY = 400
"""Of a process that reads a small file [MB]; imports take half of it."""


def peak_of(program: str, *arguments: str) -> int:
    """Most memory that a Python program of its own has taken [MB]; `ru_maxrss` would be that of who started it."""
    told = "print(next(int(line.split()[1]) >> 10 for line in open('/proc/self/status') if line.startswith('VmHWM')))"
    done = subprocess.run(
        [sys.executable, "-c", f"{program}\n{told}", *arguments], capture_output=True, text=True, timeout=120, check=False,
        cwd=Path(__file__).parents[1] / "helpers",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return int(done.stdout.splitlines()[-1])


needs_proc = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="peaks are measured on Linux")


# ---------------------------------------------------------------- numbers

NO_NUMBERS = (
    "1_0", "1.32_0", "١", "٠.٠٨", "１", "0x1p3", "0x10", "nan", "inf", "-Infinity", "1e999", "", " 1", "1 ", "1,0", "--1", "1e",
    "e5", ".", "+", "1" * 101, "1\u00a0",
)  # fmt: skip


@pytest.mark.parametrize("text", NO_NUMBERS)
def test_what_only_python_takes_for_a_number_is_none(text):
    with pytest.raises(ValueError, match="not a number"):
        parse_number(text)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_float_is_read_as_written(value):
    assert parse_number(repr(value)) == value
    assert parse_numbers(f"\t{value!r} \n+{abs(value)!r}\r.5 5.") == [value, abs(value), 0.5, 5.0]


@given(st.text(max_size=12))
def test_what_is_read_is_ascii_and_what_float_reads(text):
    try:
        value = parse_number(text)
    except ValueError:
        return
    assert text.isascii() and math.isfinite(value) and value == float(text)


def values_of(text: str, attribute: str) -> list[re.Match[str]]:
    return list(re.finditer(rf'{attribute}="([^"]*)"', text))


@pytest.mark.parametrize(("file", "reader"), [(DOOR, Door), (VEHICLE, Vehicle)])
@pytest.mark.parametrize("attribute", ["mass value", "ixx", "izz", "box size", "origin xyz", "limit lower", "axis xyz"])
@pytest.mark.parametrize(
    "other", [lambda text: f"{text}_0", lambda text: text.translate({ord("1"): "١", ord("0"): "٠"})]
)
def test_no_number_of_a_urdf_is_read_as_python_has_it(file, reader, attribute, other, tmp_path):
    text, path = file.read_text(encoding="utf-8"), tmp_path / "other.urdf"
    for one in values_of(text, attribute):
        if other(one[1]) != one[1]:
            path.write_text(text[: one.start(1)] + other(one[1]) + text[one.end(1) :], encoding="utf-8")
            with pytest.raises(UrdfError) as caught:
                reader(path)
            assert caught.value.file == str(path) and caught.value.given == other(one[1])


def test_blanks_that_xml_has_lose_no_inertial(tmp_path):
    """Only spaces stand between numbers for urdfdom, which left out what had a tab."""
    text, path = VEHICLE.read_text(encoding="utf-8"), tmp_path / "tabs.urdf"
    path.write_text(re.sub(r'(value|ixx|xyz)="([^"]*)"', r'\1="\t\2&#10;"', text), encoding="utf-8")
    assert Vehicle(path).mass == pytest.approx(Vehicle(VEHICLE).mass, rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<robot ", "<robot " + " ".join(f'a{k}="1"' for k in range(10_000)) + " ", "too many attributes"),
        ('value="11"', f'value="{"0" * 5000}11"', "too long"),
        ("</robot>", f'<link name="{"x" * 10_000}"/></robot>', "too long"),
        ("</robot>", f"<{'x' * 10_000}/></robot>", "too long"),
    ],
)
def test_attributes_of_a_urdf_are_few_and_short(old, new, words, tmp_path):
    path = tmp_path / "door.urdf"
    path.write_text(DOOR.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")
    with pytest.raises(UrdfError, match=words) as caught:
        Door(path)
    assert len(str(caught.value)) < 500 + len(str(path))


# ---------------------------------------------------------------- TOML, and the text of errors


@pytest.mark.parametrize("parts", [100, 500, 1000, 100_000])
def test_a_key_of_many_parts_is_refused(parts, tmp_path):
    key, path = ".".join(["a"] * parts), tmp_path / "deep.toml"
    path.write_text(f"{key} = 1\n")
    with pytest.raises(ScenarioError, match="nested too deep") as caught:
        Scenario.load(path)
    assert caught.value.file == str(path)
    with pytest.raises(ScenarioError, match="nested too deep"):
        Scenario.load("paper", parse_overrides([f"{key}=1"]))


@pytest.mark.parametrize(
    "text",
    [
        f"[planner]\nmargin = {'[' * 40}{']' * 40}",
        f"[planner]\nmargin = {'[' * 50_000}",
        "margin = " + "{a=" * 5000,
        f"[planner]\nmargin = 0x{'f' * 4000}",
        f"[planner]\nmargin = {'9' * 5000}",
        f"# {'x' * 1_000_000}",
        "\n".join(f"{'a.' * 95}b{k} = 1" for k in range(1000)),
    ],
)
def test_toml_out_of_bounds_is_refused_with_its_file(text, tmp_path):
    path = tmp_path / "task.toml"
    path.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        Scenario.load(path)
    assert caught.value.file == str(path) and len(str(caught.value)) < 600 + len(str(path))


def endless() -> list:
    found: list = []
    found += [found, found]
    return found


@pytest.mark.parametrize(
    "value", [HUGE, endless(), {"a": endless()}, "\ud800", b"\xff", object()],
    ids=["huge", "endless", "endless table", "surrogate", "bytes", "object"],
)  # fmt: skip
def test_errors_have_a_text_whatever_was_given(value):
    for refuse in (
        lambda: Scenario.load("paper", {"planner.margin": value}),
        lambda: Scenario.load("paper").replace(planner={"margin": value}),
        lambda: PlannerSection(margin=value),
        lambda: number(value, "margin"),
    ):
        with pytest.raises((ScenarioError, DimensionError)) as caught:
            refuse()
        assert 0 < len(str(caught.value).encode()) < 2000


# ---------------------------------------------------------------- MCAP


def bomb(said: int, size: int) -> bytes:
    """A chunk whose frame has so many zeros, and which says to have others."""
    data, left, sum_ = [], size, 0
    compressor = zstandard.ZstdCompressor().compressobj(size=size)
    while left:
        block = bytes(min(left, 1 << 24))
        data.append(compressor.compress(block))
        sum_, left = zlib.crc32(block, sum_), left - len(block)
    data.append(compressor.flush())
    content = b"".join(data)
    return record(CHUNK, struct.pack("<QQQII4sQ", 0, 1, said, sum_, 4, b"zstd", len(content)) + content)


@pytest.fixture(scope="module")
def small(tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("small") / "run.mcap"
    with Recorder(path, {"a": 1}) as recorder:
        for k in range(5):
            recorder.write("truth", 0.1 * k, {"x": float(k), "word": f"w{k}"})
    return path.read_bytes()


@needs_proc
@pytest.mark.parametrize("said", [1_000_000_000, 100])
def test_a_chunk_that_would_fill_the_memory_is_one_damaged_chunk(said, small, tmp_path):
    path = tmp_path / "bomb.mcap"
    path.write_bytes(small[:8] + bomb(said, 1_000_000_000) + small[8:])
    assert path.stat().st_size < 100_000
    program = (
        "import sys; from doorman.recording import Recording; r = Recording.load(sys.argv[1])\n"
        "assert r['truth']['x'].tolist() == [0, 1, 2, 3, 4] and r.damaged_chunks == 1 and not r.complete"
    )
    assert peak_of(program, str(path)) < MOST_MEMORY


def rewritten(data: bytes, change) -> bytes:
    """A recording whose chunks' contents are changed, each with its checksum."""

    def chunk(opcode: int, body: bytes) -> bytes:
        if opcode != CHUNK:
            return body
        at = 32 + struct.unpack_from("<I", body, 28)[0]
        content = change(zstandard.decompress(body[at + 8 :]))
        packed = zstandard.compress(content)
        body = body[:16] + struct.pack("<QI", len(content), zlib.crc32(content)) + body[28:at]
        return body + struct.pack("<Q", len(packed)) + packed

    return data[:8] + edited(data[8:-8], chunk) + data[-8:]


@pytest.mark.parametrize(
    "edit",
    [
        lambda body: body[:-1],
        lambda body: body + b"\0",
        lambda body: body[:4] + struct.pack("<d", math.nan) + body[12:],
        lambda body: body[:4] + struct.pack("<d", 1e300) + body[12:],
        lambda body: body[:4] + struct.pack("<d", -1.0) + body[12:],
    ],
)
def test_a_message_that_makes_no_sense_is_left_out_and_counted(edit, small, tmp_path):
    path = tmp_path / "run.mcap"
    third = struct.pack("<d", 3.0)

    def message(opcode: int, body: bytes) -> bytes:
        return body[:22] + edit(body[22:]) if opcode == MESSAGE and third in body[26:46] else body

    path.write_bytes(rewritten(small, lambda content: edited(content, message)))
    found = Recording.load(path)
    assert found["truth"]["word"].tolist() == ["w0", "w1", "w2", "w4"]
    assert found.damaged_messages == {"truth": 1} and found.damaged_chunks == 0 and not found.complete
    assert Recording.load(path).header == {"a": 1}


@pytest.mark.parametrize(
    "schema",
    [b"# doorman: " + 100_000 * b"[", b'# doorman: [["x", "number", [1000000000000]]]', b'# doorman: [["x", "number", [-1]]]',
     b'# doorman: [["x", "number", [Infinity]]]', b'# doorman: [["x", "number", []], ["x", "number", []]]',
     b'# doorman: [["x", "string", [99999999]]]'],
)  # fmt: skip
def test_schemas_out_of_bounds_are_refused_in_a_sentence(schema, small, tmp_path):
    old = next(found for chunk in contents(small) if (found := re.search(rb"# doorman: [^\n]*", chunk)))[0]

    def change(opcode: int, body: bytes) -> bytes:
        if opcode != SCHEMA or old not in body:
            return body
        head, text = body.split(old)
        size = struct.unpack("<I", head[-4:])[0] - len(old) + len(schema)
        return head[:-4] + struct.pack("<I", size) + schema + text

    path = tmp_path / "run.mcap"
    data = rewritten(small, lambda content: edited(content, change))
    path.write_bytes(data[: data.rindex(b"\x0f" + struct.pack("<Q", 4))])  # without a summary, which has the schema too
    path.write_bytes(path.read_bytes().replace(b"topic", b"tepic"))  # nor its copy
    with pytest.raises(RecordingError, match="not a schema") as caught:
        Recording.load(path)
    assert caught.value.file == str(path)


def contents(data: bytes) -> Iterator[bytes]:
    """Contents of the chunks."""
    return (zstandard.decompress(body[44:]) for _, opcode, body in records(data) if opcode == CHUNK)


# ---------------------------------------------------------------- logs

WRITERS = {"px4": (write_ulog, "log.ulg"), "ardupilot": (write_dataflash, "log.bin")}
RATE_TOPICS = {"px4": "px4/vehicle_angular_velocity_0", "ardupilot": "ardupilot/IMU_0"}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    write_run(folder / "recording.mcap", RATES, 12.0)
    return folder


def written(autopilot: str, folder: Path) -> Path:
    write, name = WRITERS[autopilot]
    write(folder / name, RATES, 0.0, 12.0, 0.0)
    return folder / name


def with_time(log: Path, at: float, micros: int) -> None:
    """Give the first gyroscope's message of a time another one."""
    data, old = bytearray(log.read_bytes()), struct.pack("<Q", round(at * 1e6))
    place = data.index(old)
    data[place : place + 8] = struct.pack("<Q", micros)
    log.write_bytes(data)


@pytest.mark.parametrize("autopilot", WRITERS)
@pytest.mark.parametrize(("at", "micros"), [(0.02, 2 * 10**12), (6.0, 2 * 10**10 + 6), (11.98, 2**64 - 1), (9.0, 7)])
def test_one_wrong_time_costs_its_message(autopilot, at, micros, run, tmp_path):
    log = written(autopilot, tmp_path)
    with_time(log, at, micros)
    found = read_log(log)
    assert found.damaged == {RATE_TOPICS[autopilot]: 1}
    topic = found.topics[RATE_TOPICS[autopilot]]
    assert len(topic.time) == 599 and topic.time[-1] < 12.0 and (np.diff(topic.time) >= 0.0).all()
    assert align(Recording.load(run), found).offset == pytest.approx(0.0, abs=0.005)


@pytest.mark.parametrize(("autopilot", "micros"), [("px4", 2 * 10**10), ("ardupilot", 4213092985657280000)])
def test_the_merge_leaves_it_out_and_says_so(autopilot, micros, run, tmp_path):
    log = written(autopilot, tmp_path)
    with_time(log, 6.0, micros)
    for options in ((), ("--offset", "0")):
        done = doorman("merge", str(run), str(log), "--json", "--out", str(tmp_path / "both.mcap"), *options)
        assert done.exit_code == 0, done.output
        assert json.loads(done.stdout)["damaged"] == {RATE_TOPICS[autopilot]: 1}
        assert str(log) in done.stderr
        merged = Recording.load(tmp_path / "both.mcap")
        assert merged.complete and max(topic.time[-1] for topic in merged.values()) < 13.0


@needs_proc
@pytest.mark.parametrize("autopilot", WRITERS)
def test_a_wrong_time_takes_no_memory(autopilot, run, tmp_path):
    log = written(autopilot, tmp_path)
    with_time(log, 6.0, 2 * 10**12)
    program = (
        "import sys; from pathlib import Path\n"
        "from doorman.recording import Recording\nfrom doorman.recording.merging import align, read_log\n"
        "align(Recording.load(sys.argv[1]), read_log(Path(sys.argv[2])))"
    )
    assert peak_of(program, str(run), str(log)) < MOST_MEMORY


@pytest.mark.parametrize("autopilot", WRITERS)
def test_a_pause_of_the_log_does_not_move_the_clock(autopilot, run, tmp_path):
    """The rates before and behind a gap are not joined by a ramp."""
    log = written(autopilot, tmp_path)
    with_time(log, 11.98, 3 * 10**9)
    assert align(Recording.load(run), read_log(log)).offset == pytest.approx(0.0, abs=0.005)


@pytest.mark.parametrize("autopilot", WRITERS)
def test_damage_in_a_log_costs_what_it_hit(autopilot, tmp_path):
    """Flipped bits, missing stretches and noise: of 600 messages a topic loses those, and what is read is what was written."""
    log = written(autopilot, tmp_path)
    whole = read_log(log).topics[RATE_TOPICS[autopilot]]
    data, name = log.read_bytes(), "xyz" if autopilot == "px4" else "GyrX"
    body = data.index(struct.pack("<Q", 20_000))
    by_time = dict(zip(whole.time.tolist(), whole.fields[name].tolist(), strict=True))
    draw = np.random.default_rng(4)
    for _ in range(60):
        at, length = int(draw.integers(body, len(data) - 400)), int(draw.choice([1, 9, 60]))
        flipped = bytes([data[at] ^ 1 << int(draw.integers(8))])
        noise = draw.integers(0, 256, length, dtype=np.uint8).tobytes()
        new, skipped = ((flipped, 1), (b"", length), (noise, 0), (noise, length))[int(draw.integers(4))]
        log.write_bytes(data[:at] + new + data[at + skipped :])
        topic = read_log(log).topics[RATE_TOPICS[autopilot]]
        assert len(topic.time) >= 600 - 8
        same = sum(by_time.get(time) == value for time, value in
                   zip(topic.time.tolist(), topic.fields[name].tolist(), strict=True))  # fmt: skip
        assert same >= 600 - 8


def test_what_is_read_of_a_ulog_is_what_pyulog_reads(tmp_path):
    log = written("px4", tmp_path)
    ours, theirs = read_log(log).topics, OtherULog(str(log))
    for data in theirs.data_list:
        topic = ours[f"px4/{data.name}_{data.multi_id}"]
        np.testing.assert_array_equal(topic.time, data.data["timestamp"] * 1e-6)
        for name, values in data.data.items():
            stem, _, index = name.removesuffix("]").partition("[")
            if stem != "timestamp" and values.dtype != np.uint64:
                own = topic.fields[stem]
                np.testing.assert_array_equal(own[:, int(index)] if index else own, values)


def test_nested_formats_and_padding_are_read_as_pyulog_reads_them(tmp_path):
    log = ULog()
    fields, rows = "inner[2] part;uint8_t flag;uint8_t[3] _padding0;", [(1.0 + k, 0.5, k, 1.5, -k, 1) for k in range(9)]
    log.topic("outer", fields, "fhfhB", rows)
    log._formats += struct.pack("<Hc", 36, b"F") + b"inner:float value;int16_t[1] number;"
    log.write(tmp_path / "log.ulg")
    (theirs,) = OtherULog(str(tmp_path / "log.ulg")).data_list
    ours = read_log(tmp_path / "log.ulg").topics["px4/outer_0"]
    assert set(ours.fields) == {"part[0].value", "part[0].number", "part[1].value", "part[1].number", "flag"}
    for name, values in ours.fields.items():
        key = f"{name}[0]" if name.endswith("number") else name
        np.testing.assert_array_equal(values, theirs.data[key])


FORMATS = {
    "long": {"bomb": "float[65535] x;"},
    "laughing": {"bomb": "a[9] x;", "a": "b[9] x;", "b": "c[9] x;", "c": "d[9] x;", "d": "e[9] x;", "e": "float x;"},
    "empty": {"bomb": "a[65535] x;", "a": "b[65535] x;", "b": "c[65535] x;", "c": ""},
    "in itself": {"bomb": "bomb x;"},
    "without a type": {"bomb": "nothing x;"},
    "twice": {"bomb": "float x;float x;"},
    "noise": {"bomb": "float[1e9] x;"},
}


@pytest.mark.parametrize("kind", FORMATS)
def test_formats_out_of_bounds_cost_their_topic(kind, run, tmp_path):
    log = ULog()
    time = np.arange(0.0, 12.0, 0.02)
    rows = [(at, *rate) for at, rate in zip(time, RATES(time) * (1.0, -1.0, -1.0), strict=True)]
    log.topic("vehicle_angular_velocity", "float[3] xyz;", "3f", rows)
    for name, fields in FORMATS[kind].items():
        text = f"{name}:uint64_t timestamp;{fields}".encode()
        log._formats += struct.pack("<Hc", len(text), b"F") + text
    log._data += struct.pack("<Hc", 3 + 4, b"A") + struct.pack("<BH", 0, 77) + b"bomb"
    log._data += struct.pack("<Hc", 12, b"D") + struct.pack("<HQH", 77, 1, 1)
    log.write(tmp_path / "log.ulg")
    found = read_log(tmp_path / "log.ulg")
    assert set(found.topics) == {"px4/vehicle_angular_velocity_0"} and found.damaged["the file"] >= 1
    assert align(Recording.load(run), found).offset == pytest.approx(0.0, abs=0.005)


def test_what_is_read_of_a_dataflash_log_is_what_pymavlink_reads(tmp_path):
    log = written("ardupilot", tmp_path)
    ours, theirs = read_log(log).topics, {}
    reader = DFReader_binary(str(log))
    while (message := reader.recv_msg()) is not None:
        if "TimeUS" in message.fmt.columns:
            field = message.fmt.instance_field
            name = f"ardupilot/{message.get_type()}" + ("" if field is None else f"_{getattr(message, field)}")
            theirs.setdefault(name, []).append(message)
    reader.close()
    assert set(ours) == set(theirs)
    for name, messages in theirs.items():
        for column in messages[0].fmt.columns:
            values = [getattr(message, column) for message in messages]
            if column == "TimeUS":
                np.testing.assert_allclose(ours[name].time, np.array(values) * 1e-6, rtol=1e-12)
            else:
                assert ours[name].fields[column].tolist() == values


# ---------------------------------------------------------------- rows of a campaign


def test_every_flipped_bit_of_a_row_is_seen(tmp_path, caplog):
    rows = [{"run": run, "seed": 4, "success": True, "reason": "opened", "x": 1.5, "y": None} for run in (0, 1)]
    for row in rows:
        write_part(row, tmp_path)
    assert read_parts(tmp_path) == dict(enumerate(rows))
    part = tmp_path / "run-0000001.parquet"
    whole = part.read_bytes()
    for bit in range(0, 8 * len(whole), 23):  # each bit of a byte in turn
        data = bytearray(whole)
        data[bit // 8] ^= 1 << bit % 8
        part.write_bytes(data)
        caplog.clear()
        assert read_parts(tmp_path) == {0: rows[0]}
        assert str(part) in caplog.text
    part.write_bytes((tmp_path / "run-0000000.parquet").read_bytes())  # another run's row
    assert set(read_parts(tmp_path)) == {0} and set(read_parts(tmp_path, removes_damaged=True)) == {0}
    assert not part.exists()


def test_a_row_without_a_checksum_is_none(tmp_path):
    import pyarrow
    from pyarrow import parquet

    parquet.write_table(pyarrow.table({"run": [3], "seed": [1], "success": [True]}), tmp_path / "run-0000003.parquet")
    assert read_parts(tmp_path) == {}


@pytest.mark.parametrize("content", ["", "[", "[" * 100_000, "[]", "1"])
def test_a_damaged_list_of_runs_is_a_sentence(content, tmp_path):
    from doorman.campaign.folder import NOT_FLOWN, read_not_flown

    (tmp_path / NOT_FLOWN).write_text(content)
    with pytest.raises(DoormanError, match="damaged"):
        read_not_flown(tmp_path)


# ---------------------------------------------------------------- meshes


def test_a_vertex_is_written_as_cpp_reads_it(tmp_path):
    box = '<box size="1.2 0.04 1.6"/>'
    path = tmp_path / "door.urdf"
    path.write_text(DOOR.read_text(encoding="utf-8").replace(box, '<mesh filename="leaf.obj"/>'), encoding="utf-8")
    (tmp_path / "leaf.obj").write_text("v 0 0 0\nv 1_0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n")
    with pytest.raises(UrdfError, match="three numbers"):
        Door(path)
