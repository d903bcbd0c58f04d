"""The vehicle at the leaf: process model, hypotheses and sensors of a tip that presses or is tied, for `doorman.estimation`."""
