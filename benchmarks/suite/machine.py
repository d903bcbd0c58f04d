"""What the figures were measured on."""

from __future__ import annotations

import os
import platform
import subprocess
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from build_native import RECIPES

from suite.environment import versions

PACKAGES = [
    "doorman", "numpy", "numba", "llvmlite", "pin", "proxsuite", "casadi", "crocoddyl", "mim-solvers", "pycddp",
    "teraplate",
]  # fmt: skip


def describe(python: Path, peers_python: Path, core: int) -> dict[str, Any]:
    """Processor, memory, load, compiler and versions."""
    return {
        "when": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "core": core,
        "memory": os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"),
        "load": os.getloadavg()[0],
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "compiler": _first_line(["cc", "--version"]),
        "versions": versions(python, PACKAGES),
        "peer_versions": versions(peers_python, PACKAGES),
        "built": {name: f"{recipe.version} ({recipe.commit[:8]})" for name, recipe in RECIPES.items()},
    }


def _processor() -> str:
    """Name, and the widest vectors that it has."""
    text = Path("/proc/cpuinfo").read_text(encoding="utf-8") if Path("/proc/cpuinfo").is_file() else ""
    fields = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in text.splitlines())}
    flags = fields.get("flags", "").split()
    widest = next((name for flag, name in (("avx512f", "AVX-512"), ("avx2", "AVX2")) if flag in flags), "")
    family = f"family {fields['cpu family']} model {fields['model']}" if "cpu family" in fields else ""
    return ", ".join(filter(None, [fields.get("model name", platform.processor()), family, widest]))


def _first_line(command: list[str]) -> str:
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=30.0, check=True).stdout.splitlines()[0]
    except (OSError, subprocess.SubprocessError, IndexError):
        return "none"
