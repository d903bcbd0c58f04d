"""Import and first plan in a fresh process, kernels compiled before."""

from __future__ import annotations

import json
import subprocess
import time
from typing import Any

from suite.process import surroundings
from suite.session import Session

PROCESSES, QUICK_PROCESSES = 7, 3

PROGRAM = """
import json, time
begun = time.perf_counter()
import doorman
imported = time.perf_counter()
planner = doorman.Planner(doorman.Scenario.load("paper"))
made = time.perf_counter()
plan = planner.plan(planner.model.start_state)
planned = time.perf_counter()
status = dict(line.split(":", 1) for line in open("/proc/self/status"))
peak = 1024 * int(status["VmHWM"].split()[0])  # ru_maxrss would count the process that started this one
print(json.dumps({
    "import": imported - begun, "planner": made - imported, "first_plan": planned - made, "usable": plan.usable,
    "at": time.time(), "on_core": time.process_time(), "peak_memory": peak,
}))
"""


def measure(session: Session) -> dict[str, Any]:
    """From the start of the interpreter to the first plan: seconds by part, and peak memory [bytes].

    The first process is not counted: it fills the cache.
    """
    rows = []
    for _ in range(1 + (QUICK_PROCESSES if session.quick else PROCESSES)):
        started = time.time()
        done = subprocess.run(
            [str(session.python), "-c", PROGRAM], capture_output=True, text=True, timeout=600.0, check=True,
            env=surroundings(),
        )  # fmt: skip
        row = json.loads(done.stdout)
        rows.append({**row, "total": row.pop("at") - started})
    return {"rows": rows[1:]}
