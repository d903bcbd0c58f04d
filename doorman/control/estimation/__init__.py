"""What is inferred from measurements: motion, forces, contact, wind and door."""
