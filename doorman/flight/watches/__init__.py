"""Watches: what is measured in flight, and told from the measurements."""
