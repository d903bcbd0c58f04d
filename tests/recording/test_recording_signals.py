"""Recording while signals strike: whole messages in a readable file, in real time."""

import gc
import signal
import subprocess
import sys
import textwrap
from types import FrameType
from typing import Any

import numpy as np
import pytest

from doorman.recording import Recorder, Recording

RECORDING_PROCESS = """
    import signal, sys
    from pathlib import Path
    import numpy as np
    from doorman.recording import Recorder
    signal.signal(signal.SIGINT, signal.default_int_handler)  # who runs in the background may have inherited that it is ignored
    recorder = Recorder(Path(sys.argv[1]), {"seed": 7})
    state, k = np.arange(9) / 7, 0
    with recorder:
        while k < 1_000_000:
            recorder.write("estimate", 0.004 * k, {"state": k * state, "step": k})
            if k % 3 == 0:
                recorder.write("mission", 0.004 * k, {"state": "open"})
            k += 1
            sys.stdout.buffer.write(b"%d\\n" % k)
            sys.stdout.flush()
"""

AT_ITS_END = 30
"""Writes in which no line is struck that end a test: a thread that syncs, or does not yet, makes a few lines more or less."""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_killed_process_leaves_a_readable_recording(tmp_path, number):
    path = tmp_path / "run.mcap"
    command = [sys.executable, "-c", textwrap.dedent(RECORDING_PROCESS), str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        assert process.stdout is not None
        for _ in range(2003):
            process.stdout.readline()
        process.send_signal(number)
        written = max([2003, *(int(line) for line in process.stdout.read().split())])
        process.wait(timeout=30)
    recording = Recording.load(path)
    estimate = recording["estimate"]
    steps = estimate["step"]
    np.testing.assert_array_equal(steps, np.arange(len(steps)))
    np.testing.assert_array_equal(estimate["state"], steps[:, None] * (np.arange(9) / 7))
    assert recording.header == {"seed": 7}
    if number == signal.SIGINT:
        assert recording.complete and len(steps) >= written  # closed by the context manager: nothing is lost
    else:
        assert not recording.complete and (written - len(steps)) * 0.004 < 0.5


def test_interrupt_at_any_line_leaves_whole_messages(tmp_path):
    """Ctrl-C strikes at the n-th line that `write` runs, for every n, those of the MCAP library included."""
    path = tmp_path / "run.mcap"
    recorder = Recorder(path, {})
    lines = struck_at = 0

    def strike(frame: FrameType, event: str, _: object) -> Any:
        nonlocal lines
        lines += event == "line"
        if lines == struck_at:
            sys.settrace(None)
            signal.raise_signal(signal.SIGINT)
        return strike

    interrupts, unstruck, k, previous_trace = 0, 0, 0, sys.gettrace()
    previous_handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    gc.disable()  # finalizers of what other tests left would be struck, which swallow it, and their lines would count
    try:
        while unstruck < AT_ITS_END:
            lines, struck_at, k = 0, struck_at + 1, k + 1
            recorder.flush()
            recorder.write(f"topic {k}", 0.2 * k, {"step": -k, "state": np.full(9, -k / 3)})
            try:
                sys.settrace(strike)
                recorder.write(f"topic {k}", 0.2 * k + 0.2, {"step": k, "state": np.full(9, k / 3)})  # writes the batch
                sys.settrace(None)
                assert lines < struck_at, "an interrupt was lost"
                unstruck += 1
            except KeyboardInterrupt:
                interrupts += 1
    finally:
        sys.settrace(previous_trace)
        gc.enable()
        signal.signal(signal.SIGINT, previous_handler)
    recorder.close()
    recording, memory = Recording.load(path), recorder.recording()
    assert interrupts == k - AT_ITS_END > 300 and recording.complete and len(recording) == k
    for recorded in (recording, memory):
        for i in range(1, k + 1):
            steps = recorded[f"topic {i}"]["step"]
            assert steps.tolist() in ([-i], [-i, i])
            np.testing.assert_array_equal(recorded[f"topic {i}"]["state"], steps[:, None] / 3 * np.ones(9))
    assert recording[f"topic {k}"]["step"].tolist() == [-k, k]  # the last one was not struck


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_every_signal_that_came_while_a_batch_was_written_is_handled_after_it(tmp_path, monkeypatch, number):
    """A second Ctrl-C lands the vehicle; it may come while the disk is slow."""
    seen = []
    before = signal.signal(number, lambda number, frame: seen.append(number))
    try:
        with Recorder(tmp_path / "run.mcap", {}) as recorder:
            recorder.write("mission", 0.0, {"state": "open"})

            def slow() -> None:
                for _ in range(2):
                    signal.raise_signal(number)
                assert not seen

            monkeypatch.setattr(recorder, "_frame", slow)
            recorder.flush()
            assert seen == [number, number]
            monkeypatch.undo()
    finally:
        signal.signal(number, before)
