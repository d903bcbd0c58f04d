"""Record a flight, load it again, and plot what you want. The figures of `doorman plot` and the replay page are there as well."""

import tempfile
from pathlib import Path

import matplotlib
import numpy as np

from doorman import Model, Recording, simulate
from doorman.visualization import replay_page

matplotlib.use("agg")
from matplotlib import pyplot as plt  # noqa: E402

with tempfile.TemporaryDirectory() as folder:
    model = Model("paper")
    simulate(model, duration=2.0, path=Path(folder) / "flight.mcap")
    recording = Recording.load(Path(folder) / "flight.mcap")
    print("topics:", ", ".join(recording.topics))
    truth, estimate = recording["truth"], recording["estimate"]
    figure, axes = plt.subplots()
    axes.plot(truth.time, np.degrees(truth["door_angle"]), label="true")
    axes.plot(estimate.time, np.degrees(estimate["state"][:, 3]), label="estimated")
    axes.set(xlabel="time [s]", ylabel="door angle [°]")
    axes.legend()
    figure.savefig(Path(folder) / "door.png")
    page = replay_page(recording, model, Path(folder) / "replay.html")
    print(f"written: door.png and {page.name}")
