#!/usr/bin/env python3
"""Install a wheel into a fresh environment outside the checkout, and use it there: check a task, and fly a part of it.

python .ci/smoke.py WHEEL CONSTRAINTS
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FLOWN = 5.0
"""Of the flight [s]: the vehicle is on its way to the door."""


def smoke(wheel: Path, constraints: Path, folder: Path) -> None:
    """Install, check and fly in a folder."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}

    def run(*command: str, status: int = 0) -> str:
        print(f"$ {' '.join(command)}", flush=True)
        ran = subprocess.run(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True, check=False)
        if ran.returncode != status:
            raise SystemExit(f"{ran.stdout}\nended with {ran.returncode} instead of {status}")
        return ran.stdout

    venv.create(folder / "venv", with_pip=True)
    python, doorman = (str(folder / "venv" / "bin" / name) for name in ("python", "doorman"))
    run(python, "-m", "pip", "install", "--quiet", "-c", str(constraints), f"{wheel}[sim,viz]")
    place = Path(run(python, "-c", "import doorman; print(doorman.__file__)").strip())
    if not place.is_relative_to(folder / "venv"):
        raise SystemExit(f"doorman comes from {place}, not from the wheel")
    print(run(doorman, "check", "paper").strip().splitlines()[-1])
    run(doorman, "open", "paper", "--duration", f"{FLOWN:g}", "--out", "run", status=1)  # 1: the door is not open yet
    summary = json.loads((folder / "run" / "summary.json").read_text(encoding="utf-8"))
    figures = {name: summary[name] for name in ("outcome", "duration_s", "collisions", "deadline_misses")}
    print(figures)
    if summary["outcome"] != "cut off" or abs(summary["duration_s"] - FLOWN) > 0.1 or summary["collisions"]:
        raise SystemExit("the flight was another one")


if __name__ == "__main__":
    file, pins = (Path(argument).resolve() for argument in sys.argv[1:])
    with tempfile.TemporaryDirectory(prefix="doorman-smoke-") as made:
        if Path(made).resolve().is_relative_to(ROOT):
            raise SystemExit("the temporary folder is inside the checkout")
        smoke(file, pins, Path(made).resolve())
