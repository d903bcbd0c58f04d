"""Other cameras than Vicon Tracker's: their clients run in processes of their own and send the stream that the receiver reads."""
