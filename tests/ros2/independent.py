"""A participant that knows ROS 2's messages from rosbags alone, in a process of its own: it prints what it hears, or sends poses.

python independent.py listen DOMAIN TYPE TOPIC COUNT [latched]
python independent.py send DOMAIN TOPIC COUNT
"""

from __future__ import annotations

import json
import math
import sys
import time
from typing import Any

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.types import array, float32, float64, int32, sequence, uint8, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
BASES = {
    "float64": float64,
    "float32": float32,
    "int32": int32,
    "uint32": uint32,
    "uint8": uint8,
    "string": str,
    "bool": bool,
}
QOS = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1000))
LATCHED = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1), Policy.Durability.TransientLocal
)
made: dict[str, Any] = {}


def dds_type(name: str) -> Any:
    """The DDS type of a message, made from rosbags' definition."""
    if name not in made:
        package, _, short = name.split("/")
        fields = {field: field_type(node) for field, node in STORE.fielddefs[name][1]}
        made[name] = make_idl_struct(short, f"{package}.msg.dds_.{short}_", fields)
    return made[name]


def field_type(node: Any) -> Any:
    kind, inner = node
    if kind == Nodetype.BASE:
        return BASES[inner[0]]
    if kind == Nodetype.NAME:
        return dds_type(inner)
    element = field_type(inner[0])
    return array[element, inner[1]] if kind == Nodetype.ARRAY else sequence[element]


def plain(value: Any) -> Any:
    if hasattr(value, "__dataclass_fields__"):
        return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__ if name != "__msgtype__"}
    if hasattr(value, "tolist"):
        return value.tolist()
    return [plain(one) for one in value] if isinstance(value, list | tuple) else value


def listen(domain: str, name: str, topic: str, count: str, latched: str = "") -> None:
    """Say when somebody publishes, and print every message as rosbags reads its bytes."""
    participant = DomainParticipant(int(domain))
    reader = DataReader(participant, Topic(participant, topic, dds_type(name)), qos=LATCHED if latched else QOS)
    end = time.monotonic() + 120.0
    while not reader.get_matched_publications() and time.monotonic() < end:
        time.sleep(0.01)
    print("ready", flush=True)
    heard = 0
    last = time.monotonic()
    while heard < int(count) and time.monotonic() < end and time.monotonic() - last < 20.0:
        for sample in reader.take(500):
            message = STORE.deserialize_cdr(sample.serialize(), name)
            print(json.dumps(plain(message)), flush=True)
            heard, last = heard + 1, time.monotonic()
        time.sleep(0.002)


def send(domain: str, topic: str, count: str) -> None:
    """Send poses of a swaying body, a hundred a second."""
    participant, name = DomainParticipant(int(domain)), "geometry_msgs/msg/PoseStamped"
    kinds = {short: dds_type(f"geometry_msgs/msg/{short}") for short in ("PoseStamped", "Pose", "Point", "Quaternion")}
    header, stamp = dds_type("std_msgs/msg/Header"), dds_type("builtin_interfaces/msg/Time")
    writer = DataWriter(participant, Topic(participant, topic, dds_type(name)), qos=QOS)
    due = time.monotonic()
    for _ in range(int(count)):
        x = 0.4 * math.sin(due)
        pose = kinds["Pose"](kinds["Point"](x, 0.3, 1.0), kinds["Quaternion"](0.0, 0.0, 0.0, 1.0))
        seconds, rest = divmod(round(due * 1e9), 1_000_000_000)
        writer.write(kinds["PoseStamped"](header(stamp(seconds, rest), "map"), pose))
        due += 0.01
        time.sleep(max(due - time.monotonic(), 0.0))


if __name__ == "__main__":
    {"listen": listen, "send": send}[sys.argv[1]](*sys.argv[2:])
