"""Commands that fly a vehicle, or write its file."""
