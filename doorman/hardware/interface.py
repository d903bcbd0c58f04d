"""Backend: what the mission loop flies, be it a simulator or a vehicle; nothing in the loop knows which."""

from doorman.signals import Backend, Command, Measurement, Source

__all__ = ["Backend", "Command", "Measurement", "Source"]
