"""Flight modes of PX4 and ArduPilot: numbers on the wire, names for people (PX4 user guide; ArduCopter's mode numbers)."""

from __future__ import annotations

from dataclasses import dataclass

_PX4_MAIN = {
    1: "manual", 2: "altitude", 3: "position", 4: "auto", 5: "acro", 6: "offboard", 7: "stabilized", 8: "rattitude",
    9: "simple", 10: "termination", 11: "altitude cruise",
}  # fmt: skip
_PX4_AUTO = {
    1: "ready", 2: "take-off", 3: "loiter", 4: "mission", 5: "return", 6: "land", 8: "follow", 9: "precision land",
    10: "VTOL take-off", 20: "descend",
}  # fmt: skip
_ARDUPILOT = {
    0: "stabilize", 1: "acro", 2: "altitude hold", 3: "auto", 4: "guided", 5: "loiter", 6: "return", 7: "circle", 9: "land",
    11: "drift", 13: "sport", 14: "flip", 15: "autotune", 16: "position hold", 17: "brake", 18: "throw", 19: "avoid",
    20: "guided without GPS", 21: "smart return", 22: "flow hold", 23: "follow", 24: "zigzag", 25: "system identification",
    26: "autorotate", 27: "auto return", 28: "turtle",
}  # fmt: skip


@dataclass(frozen=True)
class Mode:
    number: int  # `custom_mode` of HEARTBEAT
    name: str

    def __str__(self) -> str:
        return self.name


def px4_number(main: int, sub: int = 0) -> int:
    """Number `custom_mode` of a main and a sub mode of PX4."""
    return main << 16 | sub << 24


def px4_mode(number: int) -> Mode:
    """Mode of PX4 from a `custom_mode`; the sub mode counts in auto only."""
    main, sub = number >> 16 & 0xFF, number >> 24 & 0xFF
    name = _PX4_MAIN.get(main, f"mode {main}")
    if main == 4:
        return Mode(px4_number(main, sub), f"{name}: {_PX4_AUTO.get(sub, f'mode {sub}')}")
    return Mode(px4_number(main), name)


def ardupilot_mode(number: int) -> Mode:
    return Mode(number, _ARDUPILOT.get(number, f"mode {number}"))
