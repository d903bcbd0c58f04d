"""Emulators: devices of the rig that speak their real protocols on sockets and pseudo-terminals."""
