"""Sources of the door's readings, one a file."""
