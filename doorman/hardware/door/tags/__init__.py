"""AprilTags on leaf and frame, seen by a camera on the vehicle: detector, camera, source and what is printed."""
