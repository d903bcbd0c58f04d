"""What a door's URDF says of its leaf and joint, and what it leaves open."""
