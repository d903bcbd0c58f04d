"""The scene: a flight in three dimensions, as a page for the browser."""
