"""A flight process that does what its order says: answers, chatters, hangs, or dies."""

from __future__ import annotations

import json
import os
import sys
import time

prepared = 0
for line in sys.stdin:
    order = json.loads(line)
    print("told:", order.get("do", "prepare"), file=sys.stderr, flush=True)
    if order.get("do") == "hang":
        time.sleep(600)
    if order.get("do") == "die":
        os.kill(os.getpid(), 11)
    answer = {"pid": os.getpid(), "threads": os.environ["OMP_NUM_THREADS"], "order": order, "prepared": prepared}
    fails = order.get("prepare") and order["scenario"] == "unusable"
    prepared += bool(order.get("prepare"))
    print(json.dumps(answer | {"error": "it cannot be" if fails else None}), flush=True)
