"""Make the gallery: a video of a flight of every shipped scenario, and docs/gallery.md with commands, verdicts and figures.

Usage: python docs/pictures/gallery.py [NAMES …] [--runs build/gallery]

Flies what has no run there yet, draws the replay page of each by a browser without a window, and encodes WebM (VP9). Names that
are given are drawn anew, all others keep what they have. Needs the extras sim and viz, chromium, and PyAV: pip install av.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[2] / "tests")]

from animate import frames, opened  # noqa: E402

from doorman.cli.simulated.listing import first_sentence  # noqa: E402
from doorman.resources import scenario_directory, shipped  # noqa: E402
from doorman.summary import verdict  # noqa: E402

PICTURES = Path(__file__).parent
PAGE = PICTURES.parent / "gallery.md"
SPEED, RATE = 3.0, 10
"""Times real time, and frames per second of the video."""
WIDTH, HEIGHT = 640, 400
QUALITY = {"crf": "38", "b": "0", "cpu-used": "4"}
"""Of VP9: constant quality."""
PLAYED = 'style="max-width: 100%" controls muted loop playsinline preload="none"'
"""How a page plays a video: no wider than a phone."""
HEAD = """# Gallery

The scenarios that ship, flown once in simulation with the seed 0. The videos run at three times real time. `doorman list` prints
the tasks; `doorman open pull` flies one of them. `docs/pictures/gallery.py` makes this page.
"""


def main() -> None:
    """Do what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="scenarios to draw anew; all without a video if none is given")
    parser.add_argument("--runs", type=Path, default=Path("build/gallery"), help="folder of the flights")
    options = parser.parse_args()
    tasks = shipped(scenario_directory(), ".toml")
    for name in options.names or [name for name in tasks if not video_of(name).is_file()]:
        run = options.runs / name
        if not (run / "summary.json").is_file():
            subprocess.run([sys.executable, "-m", "doorman", "open", name, "--out", str(run)], check=False)
        draw(run, video_of(name))
    write_page(tasks, options.runs)


def video_of(name: str) -> Path:
    """Where the video of a scenario is."""
    return PICTURES / "gallery" / f"{name}.webm"


def draw(run: Path, video: Path) -> None:
    """Video of a run, and its frame at 60 % as the poster that stands there until it plays."""
    asked = argparse.Namespace(
        run=run, out=Path("frames.gif"), width=WIDTH, height=HEIGHT, speed=SPEED, frames_per_second=RATE, at=0.6
    )
    with opened() as browser:
        pictures = frames(browser, asked)
    video.parent.mkdir(exist_ok=True)
    encode(pictures, video)
    pictures[int(0.6 * len(pictures))].quantize(128).save(video.with_suffix(".png"), optimize=True)
    print(f"{video.name}: {len(pictures)} frames, {video.stat().st_size / 1e3:.0f} kB", flush=True)


def encode(pictures: list[Image.Image], video: Path) -> None:
    """WebM of pictures."""
    import av

    with av.open(str(video), "w") as file:
        stream = file.add_stream("libvpx-vp9", rate=Fraction(RATE), options=QUALITY)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for picture in pictures:
            file.mux(stream.encode(av.VideoFrame.from_ndarray(np.asarray(picture), format="rgb24")))
        file.mux(stream.encode())


def write_page(tasks: dict[str, Path], runs: Path) -> None:
    """The page; a task whose run is not there keeps its section."""
    written = PAGE.read_text(encoding="utf-8") if PAGE.is_file() else ""
    old = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", written, re.MULTILINE | re.DOTALL))
    sections = []
    for name, path in tasks.items():
        summary = runs / name / "summary.json"
        if summary.is_file():
            sections.append(f"## {name}\n{section(name, path, json.loads(summary.read_text(encoding='utf-8')))}")
        elif name in old:
            sections.append(f"## {name}\n{old[name].rstrip()}\n")
        else:
            sections.append(f"## {name}\n\n{first_sentence(path)}\n\n```sh\ndoorman open {name}\n```\n")
    PAGE.write_text("\n".join([HEAD, *sections]), encoding="utf-8")


def section(name: str, path: Path, summary: dict[str, Any]) -> str:
    """Words, video, command, verdict and figures of a flight."""
    _, sentence = verdict(summary)
    unit = "°" if summary["unit"] == "deg" else " m"
    places = 1 if unit == "°" else 3
    opened = summary["time_to_open_s"]
    own = PICTURES.parent / "gallery" / f"{name}.md"
    more = f" [More of this task](gallery/{name}.md)." if own.is_file() else ""
    return f"""
{first_sentence(path)}{more}

<video src="pictures/gallery/{name}.webm" poster="pictures/gallery/{name}.png" width="{WIDTH}" {PLAYED}>
<a href="pictures/gallery/{name}.webm">A video of the flight</a></video>

```sh
doorman open {name}
```

| figure | value |
| --- | --- |
| verdict | {sentence} |
| opening at the end, target | {summary["final_opening"]:.{places}f}{unit}, {summary["target_opening"]:.{places}f}{unit} |
| time to open, from the touch | {"not opened" if opened is None else f"{opened:.1f} s"} |
| smallest clearance | {summary["min_clearance_m"] * 1e3:.0f} mm |
| largest push, largest pull | {summary["max_push_force_n"] or 0.0:.1f} N, {summary["max_pull_force_n"]:.1f} N |
"""


if __name__ == "__main__":
    main()
