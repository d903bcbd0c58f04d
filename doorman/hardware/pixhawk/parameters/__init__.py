"""The autopilot's parameters: protocol, rules and files."""
