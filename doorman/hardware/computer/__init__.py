"""The computer on the vehicle: what it must have before a flight, and the system's files that give it."""

from doorman.hardware.computer.doctor import Complaint, Row, examine
from doorman.hardware.computer.system_files import SYSTEM_FILES, SystemFile

__all__ = ["SYSTEM_FILES", "Complaint", "Row", "SystemFile", "examine"]
