"""MuJoCo, imported only here and only when a plant is built: it is an optional dependency."""

from __future__ import annotations

import ctypes
import importlib
import sys
from typing import Any

from doorman.exceptions import BackendError, how_to_install


def engine() -> Any:
    """The `mujoco` module, without its habit of writing warnings to a file in the working directory."""
    try:
        mujoco = importlib.import_module("mujoco")
    except ImportError as error:
        raise BackendError(f"the simulation needs MuJoCo; {how_to_install('sim')}", field="mujoco") from error
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_ignore)
    return mujoco


def addresses(mujoco: Any, engine_model: Any, data: Any) -> tuple[int, int, int]:
    """Where the binding's own `mj_step` and what it works on are: compiled code steps without Python."""
    try:
        library = ctypes.CDLL(sys.modules[mujoco.mj_step.__module__].__file__)  # finds what the binding is linked with
        step = ctypes.cast(library.mj_step, ctypes.c_void_p).value or 0
        return step, int(engine_model._address), int(data._address)
    except (AttributeError, KeyError, OSError) as error:
        raise BackendError(
            f"MuJoCo cannot be stepped from compiled code: {error}", field="mujoco", given=mujoco.__version__,
            allowed="a version that doorman's extra `sim` installs",
        ) from error  # fmt: skip


def check_stability(mujoco: Any, data: Any) -> None:
    """Raise on what MuJoCo only counts."""
    counts = data.warning.number
    kinds = [name for name, kind in mujoco.mjtWarning.__members__.items() if name != "mjNWARNING" and counts[int(kind)]]
    raise BackendError(
        "the simulated physics became unstable", field=", ".join(kinds), given=f"time {data.time:.4f} s",
        allowed="finite, moderate states; try a higher simulation.physics_rate or a softer tip",
    )  # fmt: skip


def _ignore(message: str) -> None:
    """MuJoCo's warnings are read from its counters by `check_stability`."""
