"""Phases away from the leaf: to the door, through the doorway, and back."""
