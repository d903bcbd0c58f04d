"""The thread that talks to the autopilot, and all that it looks after."""
