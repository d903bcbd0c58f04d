"""Findings along the swing: room, postures, the rehearsed motion and what it asks for."""
