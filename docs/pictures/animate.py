"""Make an animated picture or a still of a recorded flight: its replay page, drawn by a browser without a window.

Usage: python docs/pictures/animate.py RUN OUT.gif [--width 640] [--height 400] [--speed 4] [--frames-per-second 12]
       python docs/pictures/animate.py RUN OUT.png [--width 640] [--height 400] [--at 0.6]

RUN is a folder that `doorman open` wrote. The browser is chromium, or what DOORMAN_BROWSER names.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from visualization.browser import Browser  # noqa: E402

COLORS, SAMPLES = 256, 12
"""Of the palette that all frames share, and how many frames it is made from."""
DRAWN = ((0xD5, 0x5E, 0x00), (0xCC, 0x79, 0xA7), (0xF4, 0x9E, 0xCE), (0x00, 0x9E, 0x73), (0x40, 0xC0, 0x92))
"""Colours of path, arrow and ribbon, in shade and light, which are too small in the pictures to get a place in the palette."""
PLAIN = "for (const one of document.querySelectorAll('#caption, #legend, #controls, .dg')) one.style.display = 'none'"


@contextmanager
def opened() -> Iterator[Browser]:
    """A browser with a folder of its own, closed in the end."""
    with tempfile.TemporaryDirectory() as folder:
        browser = Browser(Path(folder))
        try:
            yield browser
        finally:
            browser.close()


def main() -> None:
    """Do what the arguments say."""
    arguments = parse()
    with opened() as browser:
        pictures = frames(browser, arguments)
    if arguments.out.suffix == ".gif":
        write(pictures, arguments.out, arguments.frames_per_second)
    else:
        pictures[0].quantize(COLORS).save(arguments.out, optimize=True)
    print(f"{arguments.out}: {len(pictures)} frames, {arguments.out.stat().st_size / 1e6:.2f} MB")


def frames(browser: Browser, arguments: argparse.Namespace) -> list[Image.Image]:
    """Pictures of the page at equal intervals of the flight."""
    size = {"width": arguments.width, "height": arguments.height, "deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", **size)
    browser.open((arguments.run / "replay.html").resolve().as_uri())
    browser.click("#toggle")
    browser.evaluate(PLAIN)
    first, last = (float(browser.evaluate(f"slider.{end}")) for end in ("min", "max"))
    times = np.arange(first, last, arguments.speed / arguments.frames_per_second)
    if arguments.out.suffix != ".gif":
        times = np.array([first + arguments.at * (last - first)])
    found = []
    for time in times:
        browser.evaluate(f"show({time})")
        browser.settle()
        found.append(Image.fromarray(browser.picture().astype(np.uint8)))
    return found


def write(pictures: list[Image.Image], path: Path, rate: float) -> None:
    """A GIF that repeats; one palette for all, so that what stands still does not flicker."""
    chosen = pictures[:: max(1, len(pictures) // SAMPLES)]
    band = np.ones((chosen[0].height // 8, chosen[0].width, 1), np.uint8)
    drawn = [band * np.array(color, np.uint8) for color in DRAWN]
    palette = Image.fromarray(np.concatenate([*drawn, *map(np.asarray, chosen)])).quantize(COLORS)
    reduced = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    reduced[0].save(
        path, save_all=True, append_images=reduced[1:], duration=round(1000.0 / rate), loop=0, optimize=True
    )


def parse() -> argparse.Namespace:
    """What was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, help="folder of a run")
    parser.add_argument("out", type=Path, help="GIF, or PNG of one moment, to write")
    parser.add_argument("--width", type=int, default=720, help="[pixels]")
    parser.add_argument("--height", type=int, default=450, help="[pixels]")
    parser.add_argument("--speed", type=float, default=4.0, help="times real time")
    parser.add_argument("--frames-per-second", type=float, default=12.0)
    parser.add_argument("--at", type=float, default=0.6, help="moment of a still, as a share of the flight")
    return parser.parse_args()


if __name__ == "__main__":
    main()
