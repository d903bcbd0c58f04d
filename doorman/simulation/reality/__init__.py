"""What is truly otherwise than planner and estimators are told: vehicle, thrust, air, leaf, and the frame of the poses."""
