"""What an emulated autopilot flies, and how: plant, estimator, controller and mixer."""
