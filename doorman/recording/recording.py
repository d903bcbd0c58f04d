"""Recording: what was recorded, as arrays by topic and field; from memory or from an MCAP file, whole, cut off or damaged."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from doorman.bounds import LARGEST_LOG
from doorman.exceptions import DoormanError, RecordingError, how_to_install
from doorman.recording.files.reading import read_contents
from doorman.recording.runs import recording_file

_AXES = ("x", "y", "z")
_ANGLES = ("roll", "pitch", "yaw")
_ENTRIES = {
    **dict.fromkeys(
        ("position", "velocity", "acceleration", "force", "side_force", "tip_force", "body_rates", "wind", "disturbance"),
        _AXES,
    ),
    "attitude": _ANGLES,
    "door_place": ("x", "y", "yaw"),
    "door_place_deviation": ("x", "y", "yaw"),
}  # fmt: skip
"""Names of the entries of fields that are vectors in space; the entries of all others are numbered from 0."""


def columns(fields: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Columns of shape (m,) by name: `position_x`, `attitude_roll`, `arm_angles_0`, `states_50_8`."""
    named: dict[str, NDArray[Any]] = {}
    for field, values in fields.items():
        flat = values.reshape(len(values), -1).T
        names = _entry_names(field, values.shape[1:])
        if not named.keys().isdisjoint(names) or any(name in fields for name in names if name != field):
            names = [f"{field}[{name[len(field) + 1 :]}]" for name in names]  # another field has such a name
        named.update(zip(names, flat, strict=True))
    return named


def _entry_names(field: str, shape: tuple[int, ...]) -> list[str]:
    if not shape:
        return [field]
    axes = _ENTRIES.get(field, ())
    if len(shape) == 1 and shape[0] <= len(axes):
        return [f"{field}_{axis}" for axis in axes[: shape[0]]]
    return [f"{field}_{'_'.join(map(str, entry))}" for entry in itertools.product(*map(range, shape))]


_JUDGED = ("truth", "estimate", "mission")
"""Topics without which a run has no summary."""
_MEASURED = "door_sensor"
"""Topic by which a real run is judged, in place of its truth."""


class _UnknownNameError(RecordingError, KeyError):
    """A topic or field that the recording does not have; a KeyError too, as a mapping must raise."""


class Topic(Mapping[str, NDArray[Any]]):
    """Messages of one topic: arrays by field, with one row per message.

    Args:
        name: Name of the topic.
        time: Shape (m,) [s].
        columns: Arrays of shape (m, …) by field.
    """

    def __init__(self, name: str, time: NDArray[np.float64], columns: Mapping[str, NDArray[Any]]) -> None:
        self.name = name
        self.time = time
        self._columns = dict(columns)

    def __getitem__(self, field: str) -> NDArray[Any]:
        try:
            return self._columns[field]
        except KeyError:
            raise _UnknownNameError(
                f"topic '{self.name}' has no such field", field="field", given=field, allowed=", ".join(self)
            ) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"Topic({self.name!r}, {len(self.time)} messages of {', '.join(self)})"

    def __array__(self, *_: Any, **__: Any) -> NoReturn:
        raise RecordingError(
            f"topic '{self.name}' is a table, not an array", field="topic",
            allowed=f"its fields, such as topic['{next(iter(self), 'field')}'], or topic.to_pandas()",
        )  # fmt: skip

    def to_pandas(self) -> Any:
        """The topic as a `pandas.DataFrame`: a row a message, the time [s] as index, a column for every entry of an array.

        Vectors in space have `position_x`, `position_y`, `position_z`, attitudes `attitude_roll` and so on; other entries are
        numbered from 0, `arm_angles_0`, and by row and column, `states_50_8`. Needs pandas.

        Example:
            >>> import numpy as np
            >>> from doorman.recording import Topic
            >>> topic = Topic("truth", np.array([0.0, 0.1]), {"position": np.zeros((2, 3)), "door_angle": np.ones(2)})
            >>> list(topic.to_pandas().columns)
            ['position_x', 'position_y', 'position_z', 'door_angle']

        Returns:
            The data frame.

        Raises:
            DoormanError: if pandas is not installed.
        """
        try:
            import pandas
        except ModuleNotFoundError as error:
            raise DoormanError(
                f"a data frame needs pandas, which is not installed; {how_to_install('pandas')}",
                allowed="the arrays without it",
            ) from error
        return pandas.DataFrame(columns(self), index=pandas.Index(self.time, name="time"))


class Recording(Mapping[str, Topic]):
    """Topics by name: `recording["truth"]["door_angle"]` is an array of shape (m,), `recording["truth"].time` its times.

    All arrays are read-only. A topic without messages is not there.

    Args:
        topics: The topics.
        header: What was run, as given to the recorder.
        complete: False if the file was cut off or damaged, or could not be written to its end.
        attachments: Files that the recording carries, by name: the URDFs that were flown, and their meshes.
        damaged_chunks: How many chunks of the file could not be read.
        damaged_messages: How many messages were left out, by topic: of another type than their topic, or without a time.
    """

    def __init__(
        self,
        topics: Mapping[str, Topic],
        header: Mapping[str, Any],
        complete: bool = True,
        *,
        attachments: Mapping[str, bytes] | None = None,
        damaged_chunks: int = 0,
        damaged_messages: Mapping[str, int] | None = None,
    ) -> None:
        self._topics = dict(topics)
        self.header = dict(header)
        self.complete = complete
        self.attachments = dict(attachments or {})
        self.damaged_chunks = damaged_chunks
        self.damaged_messages = dict(damaged_messages or {})
        self._summary: dict[str, Any] | None = None

    @classmethod
    def load(cls, path: str | Path) -> Recording:
        """Read an MCAP file that `Recorder` wrote.

        A file that was cut off, as by a crash, is read up to its last whole chunk; a chunk that is damaged costs its own
        messages, and a damaged message itself. `complete` is False then, and `damaged_chunks` and `damaged_messages` say how
        many were lost.

        Args:
            path: The file, or the folder of the run.

        Returns:
            The recording.

        Raises:
            RecordingError: if the file cannot be read, is too large, is no MCAP, or holds no header of doorman's; or if a
                folder holds no recording, or several.
        """
        path = Path(path)
        file = recording_file(path) if path.is_dir() else path
        try:
            with file.open("rb") as stream:
                if (size := stream.seek(0, 2)) > LARGEST_LOG:
                    raise RecordingError("too large a file", given=size, allowed=f"up to {LARGEST_LOG} bytes")
                found = read_contents(stream)
        except OSError as error:
            raise RecordingError(f"cannot be read: {error.strerror}", file=file) from error
        except RecordingError as error:
            error.file = str(file)
            raise
        if found.header is None:
            raise RecordingError("not an MCAP file, or holds no header of a doorman recording", file=file)
        topics = {name: Topic(name, *columns) for name, columns in found.topics.items()}
        return cls(
            topics, found.header, found.complete, attachments=found.attachments, damaged_chunks=found.damaged_chunks,
            damaged_messages=found.damaged_messages,
        )  # fmt: skip

    @property
    def summary(self) -> dict[str, Any]:
        """Figures of a simulated run, as in `summary.json`, or of a real one by its sensor of the door; computed on first use.

        Raises:
            RecordingError: if a topic is missing that a run is judged by: nothing was simulated, or not even one tick.
            DoormanError: if the recorded scenario cannot be made a model any more.
        """
        if self._summary is None:
            judged_by = "truth" if _MEASURED not in self or "truth" in self else _MEASURED
            missing = [topic for topic in (judged_by, *_JUDGED[1:]) if topic not in self]
            if missing:
                raise RecordingError(
                    f"the recording has no summary, as it lacks the topic '{missing[0]}'", field="topic",
                    given=", ".join(self) or "none", allowed=f"a simulated run, with {', '.join(_JUDGED)}",
                )  # fmt: skip
            from doorman.flown import summary_of  # an upper layer: pyproject.toml allows this one import

            self._summary = summary_of(self)
        return self._summary

    @summary.setter
    def summary(self, figures: dict[str, Any]) -> None:
        self._summary = figures

    @property
    def topics(self) -> tuple[str, ...]:
        """Names of the topics, in the order of their first messages."""
        return tuple(self._topics)

    def __getitem__(self, topic: str) -> Topic:
        try:
            return self._topics[topic]
        except KeyError:
            raise _UnknownNameError(
                "the recording has no such topic", field="topic", given=topic, allowed=", ".join(self) or "none"
            ) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._topics)

    def __len__(self) -> int:
        return len(self._topics)

    def to_pandas(self, topic: str) -> Any:
        """A topic as a `pandas.DataFrame`, see `Topic.to_pandas`.

        Args:
            topic: Its name.

        Returns:
            The data frame: a row a message, the time [s] as index.

        Raises:
            RecordingError: if there is no such topic.
            DoormanError: if pandas is not installed.
        """
        return self[topic].to_pandas()

    def __array__(self, *_: Any, **__: Any) -> NoReturn:
        raise RecordingError("a recording is no array", allowed=f"a topic: to_pandas(topic), with {', '.join(self)}")

    def __repr__(self) -> str:
        return f"Recording({', '.join(f'{name}: {len(topic.time)}' for name, topic in self.items())})"
