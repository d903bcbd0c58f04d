"""Control: state converter, disturbance observer and position controller between planner and vehicle."""
