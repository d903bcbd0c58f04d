"""What the link sends by itself: setpoints, mocap poses and a place on earth."""
