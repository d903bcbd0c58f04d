"""Watches: what is measured in flight, and what follows from it."""
