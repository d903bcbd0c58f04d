"""Start and goal postures: what a scenario leaves open is found, inside joint limits and constraints and far from them."""
