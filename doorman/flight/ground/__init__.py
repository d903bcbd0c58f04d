"""On the ground: what is checked, listened to and rehearsed before anything is armed."""
