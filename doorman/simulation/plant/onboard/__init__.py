"""On board at the physics rate: attitude loop, mixer and servos."""
