"""Parameters of the emulated autopilots: how they travel, and the real ones' defaults."""

from __future__ import annotations

import struct
from collections.abc import Mapping

_INT8, _INT16, _INT32, _REAL32 = 2, 4, 6, 9
_CODES = {_INT8: "<b", _INT16: "<h", _INT32: "<i"}
"""Struct format of an integer MAV_PARAM_TYPE."""
Defaults = dict[str, tuple[float, int]]
"""Value and MAV_PARAM_TYPE by name."""


def _typed(values: Mapping[int, Mapping[str, float]]) -> Defaults:
    return {name: (value, kind) for kind, named in values.items() for name, value in named.items()}


PX4_DEFAULTS = _typed({
    _REAL32: {"COM_OF_LOSS_T": 1.0, "COM_DISARM_LAND": 2.0, "COM_DISARM_PRFLT": 10.0, "RTL_RETURN_ALT": 60.0,
              "RTL_MIN_DIST": 10.0, "RTL_LAND_DELAY": 0.0, "NAV_ACC_RAD": 10.0, "MPC_THR_HOVER": 0.5, "THR_MDL_FAC": 0.0,
              "EKF2_EVP_NOISE": 0.1, "EKF2_EVA_NOISE": 0.1, "EKF2_EV_DELAY": 0.0},
    _INT32: {"COM_OBL_RC_ACT": 0, "COM_DL_LOSS_T": 10, "COM_LOW_BAT_ACT": 0, "NAV_DLL_ACT": 0, "NAV_RCL_ACT": 2,
             "RTL_CONE_ANG": 45, "RTL_TYPE": 0, "MPC_YAW_MODE": 0, "EKF2_EV_CTRL": 0, "EKF2_HGT_REF": 1,
             "EKF2_GPS_CTRL": 7, "EKF2_BARO_CTRL": 1, "EKF2_RNG_CTRL": 1, "EKF2_MAG_TYPE": 0},
})  # fmt: skip
"""Parameters of PX4 as delivered."""
ARDUPILOT_DEFAULTS = _typed({
    _REAL32: {"GUID_TIMEOUT": 3.0, "FS_GCS_TIMEOUT": 5.0, "BATT_LOW_VOLT": 10.5, "BATT_CRT_VOLT": 0.0,
              "MOT_THST_HOVER": 0.35, "MOT_THST_EXPO": 0.65, "MOT_BAT_VOLT_MAX": 0.0, "WPNAV_JERK": 1.0},
    _INT32: {"GUID_OPTIONS": 0, "FS_OPTIONS": 16, "RTL_ALT": 1500, "RTL_LOIT_TIME": 5000},
    _INT16: {"SYSID_MYGCS": 255, "SCHED_LOOP_RATE": 400, "VISO_DELAY_MS": 10, "RTL_CLIMB_MIN": 0,
             "RTL_ALT_FINAL": 0},
    _INT8: {"FS_GCS_ENABLE": 0, "FS_EKF_ACTION": 1, "FS_THR_ENABLE": 1, "BATT_FS_LOW_ACT": 0, "BATT_FS_CRT_ACT": 0,
            "DISARM_DELAY": 10, "ATC_ANGLE_BOOST": 1, "GPS1_TYPE": 1, "COMPASS_USE": 1, "COMPASS_USE2": 1,
            "COMPASS_USE3": 1, "EK3_SRC1_POSXY": 3, "EK3_SRC1_POSZ": 1, "EK3_SRC1_YAW": 1, "EK3_SRC1_VELXY": 3,
            "EK3_SRC1_VELZ": 3, "VISO_TYPE": 0, "VISO_QUAL_MIN": 0, "WP_YAW_BEHAVIOR": 2},
})  # fmt: skip
"""Parameters of ArduPilot as delivered."""
PX4_MOCAP: dict[str, float] = {
    "EKF2_EV_CTRL": 11, "EKF2_HGT_REF": 3, "EKF2_GPS_CTRL": 0, "EKF2_RNG_CTRL": 0,
    "EKF2_MAG_TYPE": 5, "EKF2_EVP_NOISE": 0.01, "EKF2_EVA_NOISE": 0.02,
}  # fmt: skip
"""Set-up of PX4 for flights by mocap alone."""
ARDUPILOT_MOCAP: dict[str, float] = {
    "GPS1_TYPE": 0, "COMPASS_USE": 0, "COMPASS_USE2": 0, "COMPASS_USE3": 0, "EK3_SRC1_POSXY": 6, "EK3_SRC1_POSZ": 6,
    "EK3_SRC1_YAW": 6, "EK3_SRC1_VELXY": 0, "EK3_SRC1_VELZ": 0, "VISO_TYPE": 1,
}  # fmt: skip
"""Set-up of ArduPilot for flights by mocap alone."""


class ParameterStore:
    def __init__(self, defaults: Defaults, bytewise: bool) -> None:
        self._values = dict(defaults)
        self._bytewise = bytewise
        self.writes = 0  # PARAM_SETs that were taken

    def __getitem__(self, name: str) -> float:
        return self._values[name][0]

    def __setitem__(self, name: str, value: float) -> None:
        self._values[name] = (value, self._values[name][1])

    def __delitem__(self, name: str) -> None:
        del self._values[name]

    def __contains__(self, name: str) -> bool:
        return name in self._values

    @property
    def names(self) -> list[str]:
        return list(self._values)

    def get(self, name: str, otherwise: float) -> float:
        return self[name] if name in self else otherwise

    def add(self, name: str, value: float, whole: bool = False) -> None:
        self._values[name] = (value, _INT32 if whole else _REAL32)

    def to_wire(self, name: str) -> tuple[float, int]:
        """Fields of PARAM_VALUE: the value as a float, and MAV_PARAM_TYPE."""
        value, kind = self._values[name]
        code = _CODES.get(kind) if self._bytewise else None
        raw = struct.pack("<f", value) if code is None else struct.pack(code, int(value)).ljust(4, b"\0")
        return float(struct.unpack("<f", raw)[0]), kind

    def from_wire(self, name: str, field: float, kind: int) -> bool:
        if name not in self or (self._bytewise and self._values[name][1] != kind):
            return False
        code = _CODES.get(self._values[name][1])
        if code is not None and self._bytewise:
            field = float(struct.unpack_from(code, struct.pack("<f", field))[0])
        self[name] = field if code is None else float(round(field))
        self.writes += 1
        return True
