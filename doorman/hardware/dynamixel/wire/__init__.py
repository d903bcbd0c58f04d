"""Bytes, packets and registers: the line to the servos."""
