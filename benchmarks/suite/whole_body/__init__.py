"""Research: the whole-body plan flown at the leaf, on what the vehicle's sensors say."""
