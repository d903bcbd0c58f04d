"""Build acados and aligator from their sources, for this processor: python benchmarks/build_native.py [acados] [aligator].

Sources come from their public repositories, or from a folder that the environment variable NATIVE_SOURCES names, with the
repositories `acados`, `blasfeo`, `hpipm` and `aligator`, bare or not. What is built already is left as it is.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "build" / "benchmarks"


class BuildError(Exception):
    """A solver could not be built; the message says at which step, with the last lines of what was printed."""


@dataclass(frozen=True)
class Recipe:
    """How to build a solver."""

    name: str
    commit: str
    """It pins those of its submodules."""
    version: str
    repository: str
    options: Sequence[str]
    """Of CMake."""
    needed: Sequence[str]
    """Folders of the repository."""
    submodules: Sequence[str] = ()
    """Those of `external/` that are needed."""

    @property
    def folder(self) -> Path:
        """Its sources, and what is installed among them."""
        return FOLDER / self.name

    def build(self, prefix: Path | None = None) -> None:
        """Get the sources, compile them, and install libraries and headers; nothing if that is done.

        Args:
            prefix: Where libraries are that it needs.

        Raises:
            BuildError: if a step fails.
        """
        stamp = self.folder / "built"
        if stamp.is_file() and stamp.read_text(encoding="utf-8") == repr(self):
            return
        print(f"Building {self.name} {self.version} into {self.folder}: a minute or two the first time", flush=True)
        shutil.rmtree(self.folder, ignore_errors=True)  # of another version, or half of this one
        self._get_sources()
        places = [f"-DCMAKE_INSTALL_PREFIX={self.folder}", *([f"-DCMAKE_PREFIX_PATH={prefix}"] if prefix else [])]
        self._run(
            "configure it", ["cmake", "-S", ".", "-B", "build", "-DCMAKE_BUILD_TYPE=Release", *places, *self.options]
        )
        self._run("compile it", ["cmake", "--build", "build", "--target", "install", "--parallel"])
        stamp.write_text(repr(self), encoding="utf-8")

    def _get_sources(self) -> None:
        """The pinned commit, and the submodules at the commits that it pins."""
        given = os.environ.get("NATIVE_SOURCES")
        local = Path(given).absolute() if given else None
        self._clone(str(local / self.name) if local else self.repository, ".")
        self._run("leave out examples", ["git", "sparse-checkout", "set", *self.needed])
        self._check_out(self.commit, ".")
        for name in self.submodules:
            path = f"external/{name}"
            pinned = self._run(f"look up {name}", ["git", "rev-parse", f"HEAD:{path}"])
            public = self._run(f"look up {name}", ["git", "config", "-f", ".gitmodules", f"submodule.{name}.url"])
            self._clone(str(local / name) if local else public, path)
            self._check_out(pinned, path)

    def _clone(self, source: str, path: str) -> None:
        (self.folder / path).mkdir(parents=True, exist_ok=True)
        self._run(f"clone {source}", ["git", "clone", "--quiet", "--no-checkout", "--filter=blob:none", source, path])

    def _check_out(self, commit: str, path: str) -> None:
        command = ["git", "-C", path, "-c", "advice.detachedHead=false", "checkout", "--quiet", commit]
        self._run(f"check out {commit[:8]}", command)

    def _run(self, step: str, command: Sequence[str]) -> str:
        try:
            done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=1800.0)
        except FileNotFoundError:
            raise BuildError(f"{self.name}: cannot {step}: there is no {command[0]!r} here") from None
        except subprocess.TimeoutExpired:
            raise BuildError(f"{self.name}: cannot {step}: not done after half an hour") from None
        if done.returncode != 0:
            last = "\n".join((done.stdout + done.stderr).strip().splitlines()[-15:])
            raise BuildError(f"{self.name}: cannot {step}:\n{last}")
        return done.stdout.strip()


ACADOS = Recipe(
    "acados", "503364817c872d474ab5bed219c26760ac267769", "0.6.0", "https://github.com/acados/acados.git",
    (
        "-DCMAKE_C_FLAGS_RELEASE=-O3 -march=native",
        "-DBLASFEO_TARGET=X64_AUTOMATIC",  # the widest vectors that run here
        "-DHPIPM_TARGET=GENERIC",  # its hot loops are BLASFEO's
        "-DACADOS_WITH_OPENMP=OFF", "-DACADOS_SILENT=ON",
        "-DCMAKE_INSTALL_RPATH=$ORIGIN",  # its libraries find one another
    ),
    ("acados", "cmake", "external", "interfaces"), ("blasfeo", "hpipm"),
)  # fmt: skip
"""With HPIPM for quadratic programs, and no other solver."""

ALIGATOR = Recipe(
    "aligator", "c54d96450112a1bba0e3f798ac0d1f6887412df3", "0.19.0+22",
    "https://github.com/Simple-Robotics/aligator.git",
    (
        "-DCMAKE_CXX_FLAGS_RELEASE=-O3 -march=native -DNDEBUG",
        "-DBUILD_PYTHON_INTERFACE=OFF", "-DBUILD_WITH_PINOCCHIO_SUPPORT=OFF", "-DBUILD_WITH_OPENMP_SUPPORT=OFF",
        "-DBUILD_TESTING=OFF", "-DBUILD_EXAMPLES=OFF", "-DBUILD_BENCHMARKS=OFF", "-DINSTALL_DOCUMENTATION=OFF",
    ),
    ("bindings", "include", "src"),
)  # fmt: skip
"""The solver alone, in C++; release 0.19.0 does not compile with the fmt of the package index, this commit after it does."""

RECIPES = {recipe.name: recipe for recipe in (ACADOS, ALIGATOR)}


def packages(python: Path) -> Path:
    """Where an environment's wheels put the C++ libraries that they contain."""
    code = "import sysconfig; print(sysconfig.get_path('purelib'))"
    done = subprocess.run([str(python), "-c", code], capture_output=True, text=True, timeout=60.0, check=True)
    return Path(done.stdout.strip()) / "cmeel.prefix"


if __name__ == "__main__":
    for wanted in sys.argv[1:] or RECIPES:
        try:
            RECIPES[wanted].build(packages(FOLDER / "peers" / "bin" / "python"))
        except BuildError as error:
            sys.exit(str(error))
