"""Errors of doorman: each says what was given, what is allowed, and in which file or field."""

from __future__ import annotations

from pathlib import Path


def how_to_install(extra: str) -> str:
    """Words that say how an extra of doorman is installed.

    Args:
        extra: Its name in `pyproject.toml`.
    """
    return f"in a checkout of doorman: pip install -e '.[{extra}]'"


def shown(value: object, longest: int = 80) -> str:
    """What was given, for an error: its repr as far as it has one that can be printed. Never raises.

    Args:
        value: Anything: a text keeps its marks, an integer may be too long for digits.
        longest: Of the words; they are cut.
    """
    try:
        words = f"'{value}'" if isinstance(value, str) else repr(value)
    except Exception:  # digits of a long integer, a list too deep, a repr of somebody's
        words = f"an integer of {value.bit_length()} bits" if isinstance(value, int) else f"a {type(value).__name__}"
    words = words if len(words) <= longest else words[: longest - 3] + "..."
    return words.encode("utf-8", "backslashreplace").decode()


class DoormanError(Exception):
    """Base of every error that doorman raises on purpose.

    Args:
        message: One sentence that says what is wrong.
        file: File that holds the fault, if any.
        field: Dotted name of the field, argument, link or joint at fault.
        given: What was given.
        allowed: What would have been accepted, in words.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        field: str | None = None,
        given: object = None,
        allowed: str | None = None,
    ) -> None:
        self.message = message
        self.file = None if file is None else str(file)
        self.field = field
        self.given = given
        self.allowed = allowed
        super().__init__(message)

    def __str__(self) -> str:
        """Render `file: field: message (given …; allowed: …)`."""
        where = ": ".join(part for part in (self.file, self.field) if part)
        details = []
        if self.given is not None:
            details.append(f"given {shown(self.given, 120)}")
        if self.allowed is not None:
            details.append(f"allowed: {self.allowed}")
        tail = f" ({'; '.join(details)})" if details else ""
        return f"{where}: {self.message}{tail}" if where else f"{self.message}{tail}"


class ScenarioError(DoormanError):
    """A scenario file or an override is wrong: syntax, unknown key, type or range."""


class InfeasibleError(DoormanError):
    """A task is refused before it is flown: the check has found that it cannot work.

    Args:
        message: One sentence that names every error of the check, with its numbers.
        findings: Names of these errors.
    """

    def __init__(self, message: str, findings: tuple[str, ...] = ()) -> None:
        self.findings = findings
        super().__init__(message)


class UrdfError(DoormanError):
    """A URDF is missing, malformed, lacks a named link or joint, or has impossible values."""


class DimensionError(DoormanError):
    """An array has the wrong shape, type, or holds values that are not finite."""


class SingularityError(DoormanError):
    """A representation is singular here, such as Euler angles at a pitch of ±90°."""


class SolverError(DoormanError):
    """A solver was set up with options or data that cannot work."""


class BackendError(DoormanError):
    """A simulator or a device failed, or was used out of order."""


class RecordingError(DoormanError):
    """A recording cannot be written or read."""
