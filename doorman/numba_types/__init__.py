"""Types of ours in compiled code: vectors of doubles, and handles of NamedTuples."""
