"""Bytes, frames and messages: the line to the autopilot."""
