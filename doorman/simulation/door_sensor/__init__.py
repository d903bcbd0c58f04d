"""Simulated sensors of the door: readings by noise and delay, what a camera on the vehicle sees, and rendered pictures."""
