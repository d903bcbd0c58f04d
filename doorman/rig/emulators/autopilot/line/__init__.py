"""What an emulated autopilot hears and says: the socket with its faults, messages and clocks."""
