"""Files of recordings that were cut off, damaged or somebody else's, and disks that are full."""

import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from recorded import HEADER

from doorman.exceptions import RecordingError
from doorman.recording import Recorder, Recording


def test_every_truncation_gives_a_prefix(tmp_path):
    whole_path, cut_path = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    with Recorder(whole_path, HEADER) as recorder:
        for k in range(200):
            recorder.write("estimate", 0.004 * k, {"state": np.full(9, 0.1 * k)})
            if k % 5 == 0:
                recorder.write("plan", 0.004 * k, {"states": np.full((51, 9), k / 3), "status": "ok"})
    data = whole_path.read_bytes()
    whole = Recording.load(whole_path)
    lengths = []
    for size in [*range(0, len(data), len(data) // 60), *range(len(data) - 12, len(data) + 1)]:
        cut_path.write_bytes(data[:size])
        try:
            cut = Recording.load(cut_path)
        except RecordingError:
            assert size < 1000  # only where not even the header is there
            continue
        assert cut.complete == (size == len(data))
        assert cut.header == whole.header
        for name, topic in cut.items():
            m = len(topic.time)
            for field, values in topic.items():
                np.testing.assert_array_equal(values, whole[name][field][:m])
        lengths.append(len(cut["estimate"].time) if "estimate" in cut else 0)
    assert lengths == sorted(lengths) and lengths[0] == 0 and lengths[-1] == 200 and len(set(lengths)) > 5


def test_times_that_go_back_hold_up_nothing(tmp_path):
    path = tmp_path / "run.mcap"
    with Recorder(path, HEADER) as recorder:
        for time in (5.0, 1.0):
            recorder.write("topic", time, {"value": time})
        assert Recording.load(path)["topic"]["value"].tolist() == [5.0, 1.0]


@pytest.mark.parametrize("content", [b"", b"\x89MCAP", b"time,angle\n0.0,1.5\n" * 20, b"\x89MCAP0\r\n"])
def test_files_that_hold_no_recording(tmp_path, content):
    path = tmp_path / "bad.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError) as error:
        Recording.load(path)
    assert error.value.file == str(path)


def test_mcap_of_somebody_else_and_missing_file(tmp_path):
    from mcap.writer import Writer

    path = tmp_path / "other.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channel = writer.register_channel("camera", "json", writer.register_schema("image", "jsonschema", b"{}"))
        writer.add_message(channel, 0, b"{}", 0)
        writer.finish()
    with pytest.raises(RecordingError, match="no header"):
        Recording.load(path)
    with pytest.raises(RecordingError, match="cannot be read"):
        Recording.load(tmp_path / "missing.mcap")


def test_path_that_cannot_be_opened(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(RecordingError, match="cannot be written"):
        Recorder(tmp_path / "file" / "run.mcap", {})
    with pytest.raises(RecordingError, match="cannot be written"):
        Recorder(tmp_path, {})


full_disk = Path("/dev/full")


def test_full_disk_keeps_memory_and_is_told_once_at_close():
    recorder = Recorder(full_disk, {})  # every write to this device fails with ENOSPC
    for k in range(1000):
        recorder.write("topic", 0.01 * k, {"value": float(k)})
    np.testing.assert_array_equal(recorder.recording()["topic"]["value"], np.arange(1000.0))
    assert not recorder.recording().complete
    with pytest.raises(RecordingError, match="No space left"):
        recorder.close()
    recorder.close()
    with pytest.raises(ZeroDivisionError) as error, Recorder(full_disk, {}):
        raise ZeroDivisionError
    assert "No space left" in error.value.__notes__[0]


def test_disk_that_fills_up_leaves_a_readable_file(tmp_path):
    script = """
        import resource, signal, sys
        from pathlib import Path
        from doorman.exceptions import RecordingError
        from doorman.recording import Recorder
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
        recorder = Recorder(Path(sys.argv[1]), {})
        for k in range(20_000):
            recorder.write("topic", 0.001 * k, {"value": 1 / (k + 1)})
        assert len(recorder.recording()["topic"].time) == 20_000
        try:
            recorder.close()
        except RecordingError:
            print("told")
    """
    path = tmp_path / "run.mcap"
    result = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script), path], capture_output=True, text=True, timeout=60
    )
    assert result.stdout == "told\n", result.stderr
    recording = Recording.load(path)
    values = recording["topic"]["value"]
    assert not recording.complete and 100 < len(values) < 20_000
    np.testing.assert_array_equal(values, 1 / np.arange(1.0, len(values) + 1))
