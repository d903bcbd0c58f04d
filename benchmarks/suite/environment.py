"""The peers' own environment: crocoddyl's packages need another version of example-robot-data than doorman's tests."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

REQUIREMENTS = sorted(Path(__file__).parents[1].glob("peers-*.txt"))


def peers_python(folder: Path) -> Path:
    """Interpreter of an environment with everything that `benchmarks/peers-*.txt` names; made on first use.

    A file that cannot be installed is reported and left out: its peer then says itself what it misses.

    Args:
        folder: Of the environment.

    Returns:
        Path of its interpreter.
    """
    python, stamp = folder / "bin" / "python", folder / "installed"
    digest = hashlib.sha256(b"".join(file.read_bytes() for file in REQUIREMENTS)).hexdigest()
    if stamp.is_file() and stamp.read_text(encoding="utf-8") == digest:
        return python
    print(f"Installing the peers into {folder}: a minute or two the first time", flush=True)
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True, timeout=300.0)
    complete = True
    for file in REQUIREMENTS:
        quiet = ["--quiet", "--disable-pip-version-check"]
        command = [str(python), "-m", "pip", "install", *quiet, "-r", str(file)]
        result = subprocess.run(command, timeout=1800.0, capture_output=True, text=True)
        if result.returncode != 0:
            complete = False
            print(f"{file.name} cannot be installed:\n{result.stderr}", file=sys.stderr)
    if complete:
        stamp.write_text(digest, encoding="utf-8")
    return python


def versions(python: Path, packages: list[str]) -> dict[str, str]:
    """Versions of those of some packages that an environment has."""
    code = (
        "import importlib.metadata as m, sys\n"
        "for name in sys.argv[1:]:\n"
        "    try: print(name, m.version(name))\n"
        "    except m.PackageNotFoundError: pass"
    )
    done = subprocess.run(
        [str(python), "-c", code, *packages], capture_output=True, text=True, timeout=60.0, check=True
    )
    return {name: version for name, version in (line.split() for line in done.stdout.splitlines())}
