"""Make the pictures of README from a recorded push: a labelled still, the animation, and the forces that the planner keeps.

Usage: python docs/pictures/readme.py RUN, a folder that `doorman open push` wrote. Needs chromium and the extra viz.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[2] / "tests")]

from animate import PLAIN, opened, write  # noqa: E402
from visualization.browser import Browser  # noqa: E402

from doorman.recording import Recording  # noqa: E402

matplotlib.use("agg")
from matplotlib import pyplot as plt  # noqa: E402

PICTURES = Path(__file__).parent
STILL_FROM, ANIMATED_FROM, TARGET = (-1.6, 2.45, 1.35), (-2.4, 1.75, 1.45), (0.15, 0.55, 1.0)
"""Of the camera, from the hinge: on the vehicle's side of the wall, where arm and tip are seen [m]."""
STILL = 1.1
"""Moment of the still: after the tip has touched the leaf [s]."""
SIZE, ANIMATED = (1200, 680), (1080, 612)
"""[pixels]."""
SPEED, RATE = 4.0, 10.0
LABELS = (
    ("hexarotor, 3 kg", "node('scene/vehicle').getWorldPosition(new THREE.Vector3())", (0.74, 0.06)),
    ("arm of four joints", "node('scene/vehicle/servo_2').getWorldPosition(new THREE.Vector3())", (0.80, 0.44)),
    ("tip: it can only push", "world.localToWorld(new THREE.Vector3(...now.tip))", (0.06, 0.62)),
    ("force on the leaf, 6 cm a newton", "world.localToWorld(new THREE.Vector3(...now.tip).add("
     "new THREE.Vector3(...now.force).multiplyScalar(0.03)))", (0.03, 0.28)),
    ("plan for the next second", "world.localToWorld(new THREE.Vector3(...now.ribbon[9].slice(0, 3)))", (0.30, 0.06)),
    ("path of the tip", "world.localToWorld(new THREE.Vector3(...frames[frameAt(time) - 60].tip))", (0.78, 0.60)),
    ("door: mass, friction and closer are not known", "world.localToWorld(new THREE.Vector3(0.12, 0.45, 0.45))", (0.42, 0.90)),
)  # fmt: skip
"""Words, point in the world that they mean, and where they stand, as shares of the picture from its upper left."""


def main() -> None:
    """Do what the argument says."""
    run = Path(sys.argv[1])
    recording = Recording.load(run)
    mission = recording["mission"]
    touched = float(mission.time[list(mission["state"]).index("open")])
    with opened() as browser:
        look(browser, run, SIZE, STILL_FROM)
        still(browser, touched + STILL)
        look(browser, run, ANIMATED, ANIMATED_FROM)
        animation(browser)
    forces(recording)


def look(browser: Browser, run: Path, size: tuple[int, int], eye: tuple[float, float, float]) -> None:
    """Open the page, with the camera where this script wants it."""
    metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", **metrics)
    browser.open((run / "replay.html").resolve().as_uri())
    browser.click("#toggle")
    browser.evaluate(PLAIN)
    there, target = (f"{x}, {z}, {-y}" for x, y, z in (eye, TARGET))
    browser.evaluate(
        f"viewer.camera.position.set({there}); viewer.controls.target.set({target}); viewer.controls.update()"
    )


def still(browser: Browser, moment: float) -> None:
    """The labelled still."""
    browser.evaluate(f"show({moment})")
    browser.settle()
    picture = browser.picture().astype(np.uint8)
    height, width, _ = picture.shape
    figure = plt.figure(figsize=(width / 100, height / 100), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.imshow(picture)
    axes.set_axis_off()
    for words, point, (across, down) in LABELS:
        code = f"(() => {{ const time = {moment}, now = frames[frameAt(time)]; viewer.camera.updateMatrixWorld();"
        x, y = browser.evaluate(f"{code} const p = ({point}).project(viewer.camera); return [p.x, p.y]; }})()")
        place = (0.5 * (x + 1.0) * width, 0.5 * (1.0 - y) * height)
        box = {"boxstyle": "round,pad=0.35", "facecolor": "white", "edgecolor": "0.4"}
        arrow = {"arrowstyle": "-", "color": "0.15", "linewidth": 1.3, "shrinkB": 2}
        axes.annotate(words, place, (across * width, down * height), fontsize=15, bbox=box, arrowprops=arrow)
    figure.savefig(PICTURES / "flight.png", dpi=100)


def animation(browser: Browser) -> None:
    """The animation."""
    first, last = (float(browser.evaluate(f"slider.{end}")) for end in ("min", "max"))
    pictures = []
    for time in np.arange(first, last, SPEED / RATE):
        browser.evaluate(f"show({time})")
        browser.settle()
        pictures.append(Image.fromarray(browser.picture().astype(np.uint8)))
    write(pictures, PICTURES / "push.gif", RATE)


def forces(recording: Recording) -> None:
    """What the planner keeps: the tip presses, and the leaf goes no faster than a push can stop it."""
    truth, estimate = recording["truth"], recording["estimate"]
    figure, (angle, force) = plt.subplots(2, 1, sharex=True, figsize=(8.0, 4.6), layout="constrained")
    angle.plot(truth.time, np.degrees(truth["door_angle"]), color="#0072B2", label="true")
    angle.plot(
        estimate.time, np.degrees(estimate["state"][:, 3]), "--", color="#D55E00", linewidth=1.0, label="estimated"
    )
    angle.set(ylabel="door angle [°]")
    force.axhspan(-3.0, 0.0, color="0.88")
    force.text(0.01, 0.02, "a tip that pushes cannot pull", transform=force.transAxes, fontsize=9, color="0.3")
    force.plot(truth.time, truth["tip_normal_force"], color="0.6", linewidth=0.8, label="true")
    force.plot(estimate.time, estimate["normal_force"], color="#009E73", linewidth=1.0, label="estimated")
    top = float(np.nanquantile(truth["tip_normal_force"], 0.999))
    force.set(
        xlabel="time [s]",
        ylabel="push of the tip [N]",
        ylim=(-0.15 * top, 1.15 * top),
        xlim=(truth.time[0], truth.time[-1]),
    )
    for axes in (angle, force):
        axes.legend(loc="upper right", fontsize=9)
        axes.grid(alpha=0.3)
    figure.savefig(PICTURES / "push_forces.png", dpi=110)


if __name__ == "__main__":
    main()
