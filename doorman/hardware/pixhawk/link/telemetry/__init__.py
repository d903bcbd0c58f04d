"""Telemetry: what the autopilot sends, at which rates, and its clock on this computer's."""
