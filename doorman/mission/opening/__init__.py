"""At the leaf: how the vehicle follows plans, gripped or pushed, and how far the door is on its way to the goal."""
