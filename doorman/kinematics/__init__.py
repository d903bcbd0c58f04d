"""Kinematics of vehicle and door: Pinocchio models, attitude, and the constraint that ties them together."""
