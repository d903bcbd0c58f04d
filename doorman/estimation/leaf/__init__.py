"""The vehicle at the leaf: process model, hypotheses and sensors of a tip that pushes or grips, for `doorman.estimation`."""
