"""Recording: one path for what simulation and flight report, into memory and into a crash-safe MCAP file."""

from doorman.recording.recorder import Listener, Recorder
from doorman.recording.recording import Recording, Topic

__all__ = ["Listener", "Recorder", "Recording", "Topic"]
