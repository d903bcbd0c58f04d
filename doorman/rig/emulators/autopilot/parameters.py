"""Parameters of the emulated autopilots: defaults of the real ones, their types, and how they travel."""

from __future__ import annotations

import math
import struct

_REAL32, _INT8, _INT16, _INT32 = 9, 2, 4, 6

PX4_DEFAULTS: dict[str, tuple[float, int]] = {
    "COM_OF_LOSS_T": (1.0, _REAL32),
    "COM_OBL_RC_ACT": (0, _INT32),
    "COM_DL_LOSS_T": (10, _INT32),
    "COM_DISARM_LAND": (2.0, _REAL32),
    "COM_DISARM_PRFLT": (10.0, _REAL32),
    "COM_LOW_BAT_ACT": (0, _INT32),
    "NAV_DLL_ACT": (0, _INT32),
    "NAV_RCL_ACT": (2, _INT32),
    "RTL_RETURN_ALT": (60.0, _REAL32),
    "RTL_CONE_ANG": (45, _INT32),
    "RTL_MIN_DIST": (10.0, _REAL32),
    "RTL_LAND_DELAY": (0.0, _REAL32),
    "RTL_TYPE": (0, _INT32),
    "NAV_ACC_RAD": (10.0, _REAL32),
    "NAV_MC_ALT_RAD": (0.8, _REAL32),
    "MIS_TAKEOFF_ALT": (2.5, _REAL32),
    "MPC_YAW_MODE": (0, _INT32),
    "MPC_THR_HOVER": (0.5, _REAL32),
    "THR_MDL_FAC": (0.0, _REAL32),
    "EKF2_EV_CTRL": (0, _INT32),
    "EKF2_HGT_REF": (1, _INT32),
    "EKF2_GPS_CTRL": (7, _INT32),
    "EKF2_BARO_CTRL": (1, _INT32),
    "EKF2_RNG_CTRL": (1, _INT32),
    "EKF2_MAG_TYPE": (0, _INT32),
    "EKF2_EVP_NOISE": (0.1, _REAL32),
    "EKF2_EVA_NOISE": (0.1, _REAL32),
    "EKF2_EV_DELAY": (0.0, _REAL32),
    "MAV_SYS_ID": (1, _INT32),
}
"""Value and MAV_PARAM_TYPE by name."""

ARDUPILOT_DEFAULTS: dict[str, tuple[float, int]] = {
    "GUID_OPTIONS": (0, _INT32),
    "GUID_TIMEOUT": (3.0, _REAL32),
    "FS_GCS_ENABLE": (0, _INT8),
    "FS_GCS_TIMEOUT": (5.0, _REAL32),
    "FS_EKF_ACTION": (1, _INT8),
    "FS_OPTIONS": (16, _INT32),
    "FS_THR_ENABLE": (1, _INT8),
    "BATT_FS_LOW_ACT": (0, _INT8),
    "BATT_FS_CRT_ACT": (0, _INT8),
    "BATT_LOW_VOLT": (10.5, _REAL32),
    "BATT_CRT_VOLT": (0.0, _REAL32),
    "SYSID_MYGCS": (255, _INT16),
    "SCHED_LOOP_RATE": (400, _INT16),
    "DISARM_DELAY": (10, _INT8),
    "ATC_ANGLE_BOOST": (1, _INT8),
    "MOT_THST_HOVER": (0.35, _REAL32),
    "MOT_THST_EXPO": (0.65, _REAL32),
    "MOT_BAT_VOLT_MAX": (0.0, _REAL32),
    "GPS1_TYPE": (1, _INT8),
    "COMPASS_USE": (1, _INT8),
    "COMPASS_USE2": (1, _INT8),
    "COMPASS_USE3": (1, _INT8),
    "EK3_SRC1_POSXY": (3, _INT8),
    "EK3_SRC1_POSZ": (1, _INT8),
    "EK3_SRC1_YAW": (1, _INT8),
    "EK3_SRC1_VELXY": (3, _INT8),
    "EK3_SRC1_VELZ": (3, _INT8),
    "VISO_TYPE": (0, _INT8),
    "VISO_DELAY_MS": (10, _INT16),
    "VISO_QUAL_MIN": (0, _INT8),
    "RTL_ALT": (1500, _INT32),
    "RTL_CONE_SLOPE": (3.0, _REAL32),
    "RTL_LOIT_TIME": (5000, _INT32),
    "RTL_CLIMB_MIN": (0, _INT16),
    "RTL_ALT_FINAL": (0, _INT16),
    "WP_YAW_BEHAVIOR": (2, _INT8),
    "WPNAV_JERK": (1.0, _REAL32),
}
"""Value and MAV_PARAM_TYPE by name."""

PX4_MOCAP: dict[str, float] = {
    "EKF2_EV_CTRL": 11, "EKF2_HGT_REF": 3, "EKF2_GPS_CTRL": 0, "EKF2_RNG_CTRL": 0,
    "EKF2_MAG_TYPE": 5, "EKF2_EVP_NOISE": 0.01, "EKF2_EVA_NOISE": 0.02,
}  # fmt: skip
"""Set-up for flights by mocap alone."""

ARDUPILOT_MOCAP: dict[str, float] = {
    "GPS1_TYPE": 0, "COMPASS_USE": 0, "COMPASS_USE2": 0, "COMPASS_USE3": 0, "EK3_SRC1_POSXY": 6, "EK3_SRC1_POSZ": 6,
    "EK3_SRC1_YAW": 6, "EK3_SRC1_VELXY": 0, "EK3_SRC1_VELZ": 0, "VISO_TYPE": 1,
}  # fmt: skip
"""Set-up for flights by mocap alone."""

_CODES = {_INT8: ("b", 1), _INT16: ("h", 2), _INT32: ("i", 4)}


class ParameterStore:
    """Named values.

    Args:
        defaults: Value and type by name.
        bytewise: Integers travel as the bytes of the float (PX4), else as its value (ArduPilot).
    """

    def __init__(self, defaults: dict[str, tuple[float, int]], bytewise: bool) -> None:
        self._values = dict(defaults)
        self._bytewise = bytewise
        self.writes = 0
        """PARAM_SETs that were taken."""

    def __getitem__(self, name: str) -> float:
        return self._values[name][0]

    def __setitem__(self, name: str, value: float) -> None:
        self._values[name] = (value, self._values[name][1])

    def __contains__(self, name: str) -> bool:
        return name in self._values

    def __len__(self) -> int:
        return len(self._values)

    @property
    def names(self) -> list[str]:
        """In the order of their index."""
        return list(self._values)

    def add(self, name: str, value: float, whole: bool = False) -> None:
        """Be a firmware with a further parameter."""
        self._values[name] = (value, _INT32 if whole else _REAL32)

    def remove(self, name: str) -> None:
        """Be a firmware without the parameter."""
        del self._values[name]

    def to_wire(self, name: str) -> tuple[float, int]:
        """Float field and type of PARAM_VALUE."""
        value, kind = self._values[name]
        if self._bytewise and kind in _CODES:
            code, _ = _CODES[kind]
            raw = struct.pack(f"<{code}", int(value)).ljust(4, b"\0")
            return float(struct.unpack("<f", raw)[0]), kind
        return float(struct.unpack("<f", struct.pack("<f", value))[0]), kind

    def from_wire(self, name: str, field: float, kind: int) -> bool:
        """Take PARAM_SET's field; False if the parameter is unknown or of another type, or no number for ArduPilot."""
        if name not in self._values or not (self._bytewise or math.isfinite(field)):
            return False
        true_kind = self._values[name][1]
        if self._bytewise and true_kind != kind:
            return False
        if self._bytewise and true_kind in _CODES:
            code, size = _CODES[true_kind]
            field = float(struct.unpack(f"<{code}", struct.pack("<f", field)[:size])[0])
        self[name] = float(round(field)) if true_kind in _CODES else field
        self.writes += 1
        return True
