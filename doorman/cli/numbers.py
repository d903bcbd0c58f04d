"""Lists of whole numbers on the command line."""

from __future__ import annotations

from doorman.exceptions import DoormanError


def whole_numbers(text: str | None, option: str) -> tuple[int, ...] | None:
    """Numbers between commas.

    Args:
        text: Such as `1,2,3`; None stays None.
        option: Its name, for the error.

    Returns:
        The numbers.

    Raises:
        DoormanError: if one of them is not a whole number.
    """
    if text is None:
        return None
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError as error:
        raise DoormanError("not whole numbers", field=option, given=text, allowed="such as 1,2,3") from error
