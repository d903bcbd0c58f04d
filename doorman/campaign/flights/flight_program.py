"""Flight program: a process of its own that flies one order after the other, and dies with the process that started it.

Orders and answers are lines of JSON on stdin and stdout. The first order only prepares; its answer comes when every kernel is
compiled or loaded. Of all flight processes of a machine one at a time prepares: what one compiles, the others load.
"""

from __future__ import annotations

import ctypes
import functools
import json
import os
import queue
import sys
import threading
import time
import traceback
from pathlib import Path
from typing import Any

from doorman.campaign.flights.orders import OtherSoftware, check_software, unpacked
from doorman.compilation import cache_directory, kernel_counts
from doorman.exceptions import DoormanError
from doorman.locks import locked
from doorman.mission.simulate import prepare, simulate
from doorman.model import Model
from doorman.scenario import Scenario

_INFRASTRUCTURE = (OSError, MemoryError, ImportError)
"""What a flight is not to blame for."""
_contents: dict[str, str] = {}
"""Files of the orders, as the last preparation brought them."""


def main() -> None:
    """Answer orders until stdin ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # whatever a library prints must not be taken for an answer
    orders: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(orders,), daemon=True).start()
    while True:
        order = orders.get()
        answers.write(json.dumps(answer(order)) + "\n")
        answers.flush()


def answer(order: dict[str, Any]) -> dict[str, Any]:
    """Fly or prepare; an error is an answer too."""
    started, compiled = time.perf_counter(), kernel_counts().compiled
    result: dict[str, Any] = {"summary": None, "error": None}
    try:
        check_software(order)
        if order.get("prepare"):
            _contents.clear()
            _contents.update(order["contents"])
        scenario = unpacked(order, _contents, Path.cwd())
        if order.get("prepare"):
            with locked(cache_directory() / "preparing.lock", wait=True):  # alone on this machine
                prepare(scenario)
        else:
            result["summary"] = _fly(scenario, order)
    except Exception as error:  # whatever goes wrong in a flight is this flight's result
        traceback.print_exc()
        result["error"] = f"{type(error).__name__}: {error}"
        result["lost"] = isinstance(error, _INFRASTRUCTURE) and not isinstance(error, DoormanError)
        result["lost"] |= isinstance(error, OtherSoftware)
    give_back_memory()
    result["wall_time_s"] = time.perf_counter() - started
    result["kernels_compiled"] = kernel_counts().compiled - compiled
    return result


def give_back_memory() -> None:
    """Give the system what is free: glibc keeps the small blocks of a recording, and flight after flight takes more."""
    # Other C libraries have no such call.
    if sys.platform == "linux" and (trim := getattr(ctypes.CDLL(None), "malloc_trim", None)) is not None:
        trim(0)


def _fly(scenario: Scenario, order: dict[str, Any]) -> dict[str, Any]:
    """Fly a draw whatever the check would say: its row tells what happened."""
    model = _model(scenario)
    return simulate(model, order["duration"], order["seed"], path=order.get("path"), force=True).summary


@functools.lru_cache(maxsize=1)
def _model(scenario: Scenario) -> Model:
    """The model of the scenario that was flown last: in a batch it is the next flight's, too."""
    return Model(scenario)


def _listen(orders: queue.SimpleQueue[dict[str, Any]]) -> None:
    for line in sys.stdin:
        orders.put(json.loads(line))
    os._exit(0)  # the campaign, which waits for answers, has ended


if __name__ == "__main__":
    main()
