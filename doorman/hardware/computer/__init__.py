"""The computer on the vehicle: what it must have before a flight, and the system's files that give it."""
