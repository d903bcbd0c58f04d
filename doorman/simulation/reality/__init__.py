"""What is truly otherwise than planner and estimators believe: vehicle, thrust, air, leaf, and the frame of the poses."""
