"""How a leaf moves with its door's angle, in numbers, in symbols and in the units of its joint."""
