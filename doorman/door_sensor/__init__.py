"""What measures the door: its settings, readings for the estimate, and AprilTags on leaf and frame."""
