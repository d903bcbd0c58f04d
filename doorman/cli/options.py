"""Arguments and options that several commands share, and what the shell may complete them to."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer


def flag(name: str, help: str, *others: str) -> Any:
    """An option that is on where it is given."""
    return typer.Option(name, *others, help=help)


def valued(metavar: str | None, help: str, otherwise: str | bool = True, *names: str, **more: Any) -> Any:
    """An option with a value; `otherwise` says what holds without it, in words or by the default itself."""
    return typer.Option(*names, metavar=metavar, help=help, show_default=otherwise, **more)


def folder(otherwise: str) -> Any:
    """Option of the folder with the results."""
    return valued("DIR", "Folder for the results.", otherwise)


def complete_scenario(incomplete: str) -> list[str]:
    """Shipped scenarios and TOML files that begin so."""
    from doorman.resources import scenario_directory

    return _names_and_files(incomplete, scenario_directory())


def _names_and_files(incomplete: str, directory: Path) -> list[str]:
    from doorman.resources import shipped

    folder, slash, _ = incomplete.rpartition("/")
    beside = Path(folder + slash or ".")
    entries = sorted(beside.iterdir()) if beside.is_dir() else []
    files = [entry.name for entry in entries if entry.suffix == ".toml"]
    folders = [f"{entry.name}/" for entry in entries if entry.is_dir() and not entry.name.startswith(".")]
    names = [*shipped(directory, ".toml"), *(f"{folder}{slash}{name}" for name in (*files, *folders))]
    return [name for name in names if name.startswith(incomplete)]


def complete_vehicle(incomplete: str) -> list[str]:
    """Shipped vehicle files and TOML files that begin so."""
    from doorman.resources import vehicle_directory

    return _names_and_files(incomplete, vehicle_directory())


def complete_setting(incomplete: str) -> list[str]:
    """Keys of a scenario that begin so, ready for a value."""
    from doorman.scenario import Scenario

    return [f"{key}=" for key in _keys(Scenario, "") if key.startswith(incomplete)]


def _keys(section: Any, prefix: str) -> list[str]:
    """Dotted keys of a table and of the tables in it."""
    found = []
    for name, field in section.model_fields.items():
        if hasattr(field.annotation, "model_fields"):
            found += _keys(field.annotation, f"{prefix}{name}.")
        elif prefix:
            found.append(prefix + name)
    return found


Source = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="Name of a shipped scenario, or path of a TOML file.",
        autocompletion=complete_scenario,
    ),
]
Sources = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="SCENARIO",
        help="Names of shipped scenarios, or paths of TOML files.",
        show_default="all shipped scenarios",
        autocompletion=complete_scenario,
    ),
]
Settings = Annotated[
    list[str] | None,
    valued(
        "KEY=VALUE",
        "Override a key of the scenario: planner.margin=0.01. The value is TOML; a bare word is a string. Repeatable.",
        True,
        "--set",
        autocompletion=complete_setting,
    ),  # fmt: skip
]
Vehicle = Annotated[
    str | None,
    valued(
        "FILE",
        "Vehicle file: everything that belongs to the vehicle; `doorman vehicle new` writes one.",
        "the scenario's vehicle",
        "--vehicle",
        autocompletion=complete_vehicle,
    ),  # fmt: skip
]
FeedPort = Annotated[
    int | None,
    valued("PORT", "Also send the flight to `doorman ros2`, which listens on 51100.", "not sent", "--feed", min=1, max=65535),
]  # fmt: skip
Run = Annotated[
    Path | None,
    typer.Argument(metavar="[RUN]", help="A run's folder, or an MCAP file.", show_default="the newest run under runs"),
]
Json = Annotated[bool, flag("--json", "Print the result as JSON, and messages to stderr; no progress bar.")]
