"""From newtons to the autopilot's normalised thrust."""
