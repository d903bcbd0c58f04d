"""Commands that read a recorded run."""
