"""Hardware: the interface that the mission flies, and the adapters behind it."""
