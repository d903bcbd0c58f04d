"""doorman: aerial manipulators that open hinged doors."""

from doorman.exceptions import DoormanError
from doorman.model import Model
from doorman.scenario import Scenario

__all__ = ["DoormanError", "Model", "Scenario"]
__version__ = "0.1.0"
