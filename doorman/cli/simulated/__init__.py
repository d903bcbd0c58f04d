"""Commands that fly or judge a scenario in simulation."""
