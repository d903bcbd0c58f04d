"""Rules of the emulated autopilots: one brain, and a table of each dialect."""
