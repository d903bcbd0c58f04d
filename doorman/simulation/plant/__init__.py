"""The MuJoCo plant, and what runs on board at its rate."""
