"""Sections of a scenario, one table of the file each."""
