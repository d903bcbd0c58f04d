"""One plan from free flight to contact."""
