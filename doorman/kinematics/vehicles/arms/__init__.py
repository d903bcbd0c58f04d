"""The arm of a vehicle: its chain of joints, its constants, and the kernel of its points."""
