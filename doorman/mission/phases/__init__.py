"""Phases of a mission, one object a phase: how it begins, what it does each tick, what follows, and what its time-out means."""
